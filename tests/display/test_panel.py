"""The panel without a window: its numbers, and machines without its packages."""

from __future__ import annotations

import math
import os
import subprocess
import sys

import pytest

from hmdwarp.display import CONTROLS, Status
from hmdwarp.display.desktop.control_panel import PANEL_REMEDY, installed

if not installed():
    pytest.skip(f"the panel's packages are not installed: {PANEL_REMEDY}", allow_module_level=True)

from hmdwarp.display.desktop.control_panel.panel import FORMAT, STEP, plots_of  # noqa: E402


def test_numbers_are_held_against_what_they_should_be():
    status = Status(values={"latency": 200.0}, budget_ms=10.0)
    status.holes.extend((math.nan, 0.03))
    named = {name: (list(values), unit, least, bad) for name, values, unit, least, bad in plots_of(status)}
    assert named["all passes"][1:] == ("ms", 12.0, 10.0)
    assert named["between pictures"][1:] == ("ms", 20.0, 15.0)
    assert named["frame age at display"][3] == math.inf
    assert named["holes before the fill"][0][1] == pytest.approx(3.0)
    assert plots_of(Status())[0][3:] == (1.0, math.inf)  # before a run has begun


def test_every_number_has_its_step():
    assert STEP.keys() == FORMAT.keys() == {listed.name for listed in CONTROLS if listed.kind == "number"}


def test_its_packages_leave_the_environment_alone():
    """They would have every program started from here take other libraries."""
    code = (
        "import os; from hmdwarp.display.desktop.window_system import choose_library; choose_library(); "
        "before = dict(os.environ); from hmdwarp.display.desktop.control_panel import installed; "
        "assert installed(); assert dict(os.environ) == before"
    )
    kept = {name: value for name, value in os.environ.items() if not name.startswith("PY") or name == "PYTHONPATH"}
    subprocess.run([sys.executable, "-c", code], check=True, env=kept)
