"""The same window under Wayland.

Weston, drawn into a virtual X screen, so that xdotool's mouse and keyboard reach it.
"""

from __future__ import annotations

import subprocess

import needs
import numpy as np
import pytest

from .programs import ROOT, SMALL, Program
from .virtual_screen import PATIENCE_S, VirtualScreen, until

pytestmark = [needs.programs("Xvfb", "xdotool", "weston"), pytest.mark.slow]  # programs of their own: 10 s

NAME = "hmdwarp-test"


@pytest.fixture
def screen(tmp_path):
    folder = tmp_path / "screen"
    folder.mkdir()
    with VirtualScreen(folder) as made:
        yield made


@pytest.fixture
def weston(screen, tmp_path):
    """A compositor with one window to a screen (its kiosk shell)."""
    runtime = tmp_path / "runtime"
    runtime.mkdir(mode=0o700)
    command = ["weston", "--backend=x11-backend.so", "--use-pixman", "--shell=kiosk-shell.so", f"--socket={NAME}"]
    environment, silent = {**screen.environment, "XDG_RUNTIME_DIR": str(runtime)}, subprocess.DEVNULL
    process = subprocess.Popen(
        [*command, "--width=1100", "--height=700", "--idle-time=0"], env=environment, stdout=silent, stderr=silent
    )
    until(lambda: (runtime / NAME).exists() or process.poll() is not None, "Weston's socket")
    assert process.poll() is None, "Weston did not start"
    yield process
    process.kill()
    process.wait(PATIENCE_S)


@pytest.fixture
def started(screen, weston, tmp_path):
    """started(options...) -> a program that Weston shows."""
    known = {name: value for name, value in screen.environment.items() if name != "DISPLAY"}
    known |= {"XDG_RUNTIME_DIR": str(tmp_path / "runtime"), "WAYLAND_DISPLAY": NAME, "PYTHONPATH": str(ROOT)}
    known["PYTHONWARNINGS"] = "error"
    return lambda *options: Program(tmp_path, "--source", "desktop", *SMALL, *options, environment=known)


def shows(screen: VirtualScreen, program: Program, holds, what: str) -> np.ndarray:
    return program.until(lambda: [picture] if holds(picture := screen.picture()) else None, what)[0]


def middle(picture: np.ndarray) -> np.ndarray:
    """Where the flat view is, without Weston's own frame."""
    return picture[100:600, 400:700].astype(int)


def test_keys_and_mouse_reach_it_and_escape_ends_it(screen, started):
    def apart(picture: np.ndarray) -> float:
        return np.abs(middle(picture) - first).mean()

    with started("--view", "flat") as program:
        screen.do("sleep", 5)  # until the first words are gone
        first = middle(shows(screen, program, lambda p: middle(p).min(axis=-1).mean() > 60, "a flat view"))
        screen.do("mousemove", 500, 300, "click", 1, "sleep", 0.5)
        screen.do("keydown", "w")
        shows(screen, program, lambda p: apart(p) > 6, "another place")
        screen.do("keyup", "w")
        screen.do("key", "r", "sleep", 1)
        shows(screen, program, lambda p: apart(p) < 6, "the first place again")
        screen.do("mousemove_relative", 100, 0)
        shows(screen, program, lambda p: apart(p) > 6, "another direction")
        screen.do("key", "Escape", "sleep", 0.5, "key", "Escape")
        status, told = program.ended()
    assert status == 0 and "the window was closed" in told and "Traceback" not in told


def test_a_compositor_that_goes_away_ends_it(screen, weston, started, tmp_path):
    with started("--out", "out") as program:
        shows(screen, program, lambda p: p[100:600].max(axis=-1).mean() > 40, "pictures")
        weston.kill()
        status, told = program.ended()
    assert status == 0 and "the window was closed" in told
    assert (tmp_path / "out" / "summary.json").is_file()
