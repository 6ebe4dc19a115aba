"""One contract for all displays.

The cases stand in contract.py and run in a program for each display: a window's context does not
mix with other tests', and OpenXR needs Monado's root.
"""

from __future__ import annotations

import functools
import json
import os
import subprocess
import sys
from collections import defaultdict
from contextlib import ExitStack

import needs
import pytest
from openxr.inside import run_inside

from .contract import CASES
from .programs import PATHS
from .virtual_screen import VirtualScreen

# A window starts an X server, OpenXR a runtime.
MARKS = {"window": [pytest.mark.slow, needs.programs("Xvfb")], "openxr": pytest.mark.slow}


@pytest.fixture(scope="module")
def failures_of(tmp_path_factory):
    """failures_of(name) -> why each case failed on that display ("": it holds)."""

    @functools.cache
    def run(name: str) -> dict[str, str]:
        with ExitStack() as stack:
            if name == "openxr":
                done = run_inside(["python3", "-m", "display.contract", name])
            else:
                environment = dict(os.environ)
                if name == "window":
                    screen = VirtualScreen(tmp_path_factory.mktemp("screen"), (400, 300))
                    environment = stack.enter_context(screen).environment
                command = [sys.executable, "-W", "error", "-m", "display.contract", name]
                how = {"capture_output": True, "text": True}
                done = subprocess.run(command, check=False, env={**environment, "PYTHONPATH": PATHS}, **how)
        lines = [json.loads(line) for line in done.stdout.splitlines() if line.startswith('{"case"')]
        broken = f"not run: the program ended with {done.returncode}\n{done.stderr[-4000:]}"
        return defaultdict(lambda: broken) | {line["case"]: line["failure"] for line in lines}

    return run


@pytest.mark.parametrize(("name", "case"), [pytest.param(*each, marks=MARKS.get(each[0], ())) for each in CASES])
def test_a_display_keeps_the_contract(failures_of, name, case):
    if failure := failures_of(name)[case]:
        pytest.fail(failure, pytrace=False)
