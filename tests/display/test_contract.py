"""One contract for all displays, contract.py, run by a pytest of its own for each.

A window's context does not mix with other tests', and OpenXR needs Monado's root.
"""

from __future__ import annotations

import os
import subprocess
import sys
from contextlib import nullcontext
from pathlib import Path

import needs
import pytest
from openxr.inside import run_inside

from .programs import PATHS, ROOT
from .virtual_screen import VirtualScreen

PYTEST = ["-m", "pytest", "-q", "--noconftest", "-p", "no:cacheprovider", "-p", "no:xdist", "tests/display/contract.py"]


def ran(name: str, folder: Path) -> subprocess.CompletedProcess[str]:
    if name == "openxr":
        return run_inside([f"HMDWARP_DISPLAY={name}", "python3", *PYTEST])
    with VirtualScreen(folder, (400, 300)) if name == "desktop" else nullcontext() as screen:
        settings = {**(screen.environment if screen else os.environ), "PYTHONPATH": PATHS, "HMDWARP_DISPLAY": name}
        return subprocess.run(
            [sys.executable, *PYTEST], check=False, env=settings, cwd=ROOT, capture_output=True, text=True
        )


@pytest.mark.parametrize(
    "name",
    [
        "offscreen",
        pytest.param("desktop", marks=[pytest.mark.slow, needs.programs("Xvfb")]),
        pytest.param("openxr", marks=pytest.mark.slow),
    ],
)
def test_a_display_keeps_the_contract(name, tmp_path):
    done = ran(name, tmp_path)
    if done.returncode:
        pytest.fail(f"{done.stdout[-30_000:]}{done.stderr[-4000:]}", pytrace=False)
