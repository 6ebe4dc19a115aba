"""Commands in Monado's root."""

from __future__ import annotations

import functools
import subprocess
from pathlib import Path

import needs
import pytest

from .root import Lacking, entered, ready_root


@functools.cache
def _root() -> Path | Lacking:
    """Build it at the first test that needs it; try once."""
    try:
        return ready_root()
    except Lacking as lacking:
        return lacking


def run_inside(command: list[str]) -> subprocess.CompletedProcess[str]:
    """Run a command there; skip the test where there can be no such root."""
    root = _root()
    if isinstance(root, Lacking):
        pytest.skip(needs.missing("OpenXR runtime", str(root)))
    command = entered(root, ["HMDWARP_BESIDE_MONADO=1", *command])
    return subprocess.run(command, check=False, stdin=subprocess.DEVNULL, capture_output=True, text=True)
