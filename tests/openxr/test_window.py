"""The frame loop with a real runtime, drawn by a window's context (GLX); the window shows the left eye, and its keys are the controls.

In a file of its own, as each has a process of its own: Mesa's EGL and GLX do not follow each other in one.
"""

from __future__ import annotations

import subprocess

import numpy as np

from .live_runs import Here, Program, quick, two_hundred_frames
from .monado import UNSEEN, WOBBLING


def test_200_frames(runtime, screen, monkeypatch, tmp_path):
    runtime(WOBBLING, UNSEEN).start()
    two_hundred_frames(Here(monkeypatch), tmp_path / "out", "GLX")


def test_the_window_shows_the_left_eye_and_takes_keys(runtime, screen, monkeypatch):
    runtime(WOBBLING, UNSEEN).start()
    here, pictures = Here(monkeypatch), []

    def after(number: int) -> None:
        if number == 8:
            pictures.append(screen.picture())
            press("t")

    here.run(quick(scene="room", frames=16), after)
    warps = [refresh.plan.choice for refresh in here.watched.shown if refresh is not None]
    assert len({str(warp) for warp in warps[:8]}) == 1 and str(warps[-1]) != str(warps[0])
    (picture,) = pictures
    seen = picture[picture.any(axis=-1)]
    assert len(seen) > 100 * 100 and len(np.unique(seen, axis=0)) > 50


def test_a_key_ends_it(runtime, screen, tmp_path):
    runtime(WOBBLING, UNSEEN).start()
    with Program(tmp_path) as program:
        program.until_recorded(5)
        press("Escape")
        assert program.status() == 0
        assert "the window was closed" in program.said


def press(key: str) -> None:
    """In the only window there is."""
    window = subprocess.run(["xdotool", "search", "--name", "hmdwarp"], check=True, capture_output=True, text=True).stdout.split()[0]
    subprocess.run(["xdotool", "windowfocus", "--sync", window, "key", key], check=True)
