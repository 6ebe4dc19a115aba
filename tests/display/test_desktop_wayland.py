"""The same window under Wayland.

Weston, drawn into a virtual X screen, so that xdotool's mouse and keyboard reach it.
"""

from __future__ import annotations

import subprocess
import sys

import needs
import numpy as np
import pytest

from .desktop_program import ROOT, SMALL
from .virtual_screen import PATIENCE_S, VirtualScreen, until

pytestmark = [needs.programs("Xvfb", "xdotool", "weston"), pytest.mark.slow]  # programs of their own: 10 s

NAME = "hmdwarp-test"


class Weston:
    """A compositor with one window to a screen (its kiosk shell).

    environment: for programs that are to be shown by it.
    """

    def __init__(self, screen: VirtualScreen, folder) -> None:
        runtime = folder / "runtime"
        runtime.mkdir(mode=0o700)
        here = {**screen.environment, "XDG_RUNTIME_DIR": str(runtime)}
        command = ["weston", "--backend=x11-backend.so", "--use-pixman", "--shell=kiosk-shell.so", f"--socket={NAME}"]
        self._process = subprocess.Popen(
            [*command, "--width=1100", "--height=700", "--idle-time=0"],
            env=here,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        until(lambda: (runtime / NAME).exists() or self._process.poll() is not None, "Weston's socket")
        assert self._process.poll() is None, "Weston did not start"
        here.pop("DISPLAY")
        self.environment = {**here, "WAYLAND_DISPLAY": NAME, "PYTHONPATH": str(ROOT)}

    def kill(self) -> None:
        self._process.kill()
        self._process.wait(PATIENCE_S)


@pytest.fixture
def screen(tmp_path):
    folder = tmp_path / "screen"
    folder.mkdir()
    with VirtualScreen(folder) as made:
        yield made


@pytest.fixture
def weston(screen, tmp_path):
    made = Weston(screen, tmp_path)
    yield made
    made.kill()


def started(weston: Weston, folder, *options: str) -> subprocess.Popen:
    command = [sys.executable, "-W", "error", "-m", "hmdwarp", "live", "--source", "desktop", *options]
    return subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=weston.environment, cwd=folder
    )


def shows(screen: VirtualScreen, process: subprocess.Popen, holds, what: str) -> np.ndarray:
    def look():
        assert process.poll() is None, process.stdout.read()
        picture = screen.picture()
        return [picture] if holds(picture) else None

    return until(look, what)[0]


def middle(picture: np.ndarray) -> np.ndarray:
    """Where the flat view is, without Weston's own frame."""
    return picture[100:600, 400:700].astype(int)


def test_keys_and_mouse_reach_it_and_escape_ends_it(screen, weston, tmp_path):
    process = started(weston, tmp_path, *SMALL, "--view", "flat")
    screen.do("sleep", 5)  # until the first words are gone
    first = middle(shows(screen, process, lambda p: middle(p).min(axis=-1).mean() > 60, "a flat view"))
    screen.do("mousemove", 500, 300, "click", 1, "sleep", 0.5)
    screen.do("keydown", "w")
    shows(screen, process, lambda p: np.abs(middle(p) - first).mean() > 6, "another place")
    screen.do("keyup", "w")
    screen.do("key", "r", "sleep", 1)
    shows(screen, process, lambda p: np.abs(middle(p) - first).mean() < 6, "the first place again")
    screen.do("mousemove_relative", 100, 0)
    shows(screen, process, lambda p: np.abs(middle(p) - first).mean() > 6, "another direction")
    screen.do("key", "Escape", "sleep", 0.5, "key", "Escape")
    told, _ = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 0 and "the window was closed" in told and "Traceback" not in told


def test_a_compositor_that_goes_away_ends_it(screen, weston, tmp_path):
    process = started(weston, tmp_path, *SMALL, "--out", str(tmp_path / "out"))
    shows(screen, process, lambda p: p[100:600].max(axis=-1).mean() > 40, "pictures")
    weston.kill()
    told, _ = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 0 and "the window was closed" in told
    assert (tmp_path / "out" / "summary.json").is_file()
