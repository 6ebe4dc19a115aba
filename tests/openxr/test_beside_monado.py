"""The files of this folder and the contract of displays, run in Monado's root.

All in one, as a fresh one compiles every module and shader anew. The window beside the headset has
a process of its own: GLX does not follow Mesa's EGL in one (X_GLXMakeCurrent: BadAccess). One test
alone:

    .venv/bin/python tests/openxr/root.py HMDWARP_BESIDE_MONADO=1 python3 -m pytest FILE -k NAME
"""

from __future__ import annotations

import subprocess

import needs
import pytest

from .root import Lacking, entered, ready_root

PYTEST = "python3 -m pytest -q -p no:cacheprovider -p no:xdist"
RUNS = (
    "tests/openxr --ignore=tests/openxr/test_mirror.py",
    "tests/openxr/test_mirror.py",
    "--noconftest tests/display/contract.py -k 'not Window'",
)


@pytest.mark.slow(100)
def test_beside_monado():
    try:
        root = ready_root()
    except Lacking as lacking:
        pytest.skip(needs.missing("OpenXR runtime", str(lacking)))
    script = "; ".join(["failed=0", *(f"{PYTEST} {run} || failed=1" for run in RUNS), "exit $failed"])
    command = entered(root, ["HMDWARP_BESIDE_MONADO=1", "HMDWARP_DISPLAY=openxr", "bash", "-c", script])
    done = subprocess.run(command, check=False, stdin=subprocess.DEVNULL, capture_output=True, text=True)
    said = f"{done.stdout}{done.stderr}"
    if done.returncode or "SKIPPED" in said:
        pytest.fail(said[-30_000:], pytrace=False)
