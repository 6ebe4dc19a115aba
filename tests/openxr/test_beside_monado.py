"""Each file of this folder, run in Monado's root.

A file has a process of its own: GLX does not follow Mesa's EGL in one (X_GLXMakeCurrent:
BadAccess). One test alone:

    .venv/bin/python tests/openxr/root.py HMDWARP_BESIDE_MONADO=1 python3 -m pytest FILE -k NAME
"""

from __future__ import annotations

import pytest

from .conftest import INSIDE
from .inside import run_inside


@pytest.mark.slow(60)
@pytest.mark.parametrize("name", INSIDE)
def test_beside_monado(name):
    done = run_inside(
        ["python3", "-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "no:xdist", f"tests/openxr/{name}"]
    )
    said = f"{done.stdout}{done.stderr}"
    if done.returncode or "SKIPPED" in said:
        pytest.fail(said[-30_000:], pytrace=False)
