"""One contract for all displays, contract.py, run by a pytest of its own for each.

A window's context does not mix with other tests'. OpenXR's is in openxr/test_beside_monado.py.
"""

from __future__ import annotations

import os
import subprocess
import sys
from contextlib import nullcontext

import needs
import pytest

from .programs import PATHS, ROOT
from .virtual_screen import VirtualScreen

PYTEST = ["-m", "pytest", "-q", "--noconftest", "-p", "no:cacheprovider", "-p", "no:xdist", "tests/display/contract.py"]


@pytest.mark.parametrize(
    "name", ["offscreen", pytest.param("desktop", marks=[pytest.mark.slow, needs.programs("Xvfb")])]
)
def test_a_display_keeps_the_contract(name, tmp_path):
    with VirtualScreen(tmp_path, (400, 300)) if name == "desktop" else nullcontext() as screen:
        settings = {**(screen.environment if screen else os.environ), "PYTHONPATH": PATHS, "HMDWARP_DISPLAY": name}
        done = subprocess.run(
            [sys.executable, *PYTEST], check=False, env=settings, cwd=ROOT, capture_output=True, text=True
        )
    if done.returncode:
        pytest.fail(f"{done.stdout[-30_000:]}{done.stderr[-4000:]}", pytrace=False)
