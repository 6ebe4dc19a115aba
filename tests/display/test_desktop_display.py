"""The display of the desktop as the driver sees it, in processes of their own.

A window's context does not mix with other tests'.
"""

from __future__ import annotations

import os
import subprocess
import sys

import needs
import pytest

from .desktop_program import ROOT, SMALL, Live
from .virtual_screen import PATIENCE_S, VirtualScreen, needs_a_screen, until

pytestmark = [needs_a_screen, pytest.mark.slow]  # programs of their own: 15 s


@pytest.fixture(scope="module")
def screen(tmp_path_factory):
    with VirtualScreen(tmp_path_factory.mktemp("screen"), (700, 500)) as made:
        yield made


@pytest.mark.parametrize("what", ["twice", "beside", "source", "switches", "bare", "reset", "colours", "words"])
def test_alone(screen, what):
    paths = os.pathsep.join([str(ROOT), str(ROOT / "tests")])
    command = [sys.executable, "-W", "error", "-m", "display.window_alone", what]
    environment = {**screen.environment, "PYTHONPATH": paths}
    done = subprocess.run(command, check=False, capture_output=True, text=True, env=environment, timeout=PATIENCE_S)
    assert done.returncode == 0, done.stderr


@needs.programs("xrandr")
def test_a_full_screen_that_is_unplugged_becomes_a_window_again(screen, tmp_path):
    def plugged(option: str) -> None:
        # Xvfb takes its output off, and then refuses to shrink to nothing, which xrandr asks for
        # besides.
        subprocess.run(
            ["xrandr", "--output", "screen", option], check=False, env=screen.environment, timeout=PATIENCE_S
        )

    with Live(screen, tmp_path, *SMALL) as live:
        screen.do("mousemove", 100, 100)
        before = live.geometry
        live.press("F11")
        until(lambda: live.geometry == (0, 0, 700, 500), "full screen")
        plugged("--off")
        try:
            until(lambda: live.geometry == before, "the old place")
            live.press("bracketright")
            live.titled(" 100 ms")
        finally:
            plugged("--auto")
        live.press("F11")
        until(lambda: live.geometry == (0, 0, 700, 500), "full screen again")
        live.press("Escape")
        status, told = live.ended()
    assert status == 0 and "Traceback" not in told
