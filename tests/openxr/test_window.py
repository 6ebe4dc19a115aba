"""Live runs with a real runtime where there is a screen.

Drawn by a window's context (GLX), whose keys are the controls.

In a file of its own, as each has a process of its own: GLX does not follow Mesa's EGL in one
(X_GLXMakeCurrent: BadAccess).
"""

from __future__ import annotations

import signal
import subprocess

from .live_runs import Here, Program, many_frames, quick
from .monado import UNSEEN, WOBBLING


def press(key: str) -> None:
    """In the window that has the keyboard, the only one there is."""
    subprocess.run(["xdotool", "key", key], check=True)


def test_40_frames(runtime, screen, monkeypatch, tmp_path):
    runtime(WOBBLING, UNSEEN).start()
    many_frames(Here(monkeypatch), tmp_path / "out", 40, "GLX")


def test_a_key_changes_the_warp(runtime, screen, monkeypatch):
    runtime(WOBBLING, UNSEEN).start()
    here = Here(monkeypatch)
    here.run(quick(pictures=16), lambda number: press("t") if number == 6 else None)
    warps = [str(refresh.plan.choice) for refresh in here.watched.shown if refresh is not None]
    assert len(set(warps[:6])) == 1
    assert warps[-1] != warps[0]


def test_a_key_ends_it(runtime, screen, tmp_path):
    runtime(WOBBLING, UNSEEN).start()
    with Program(tmp_path) as program:
        program.until_recorded(5)
        press("Escape")
        assert program.status() == 0
        assert "the window was closed" in program.said


def test_without_a_service_the_window_is_taken_and_the_reason_told(runtime, screen, tmp_path):
    runtime(WOBBLING, UNSEEN)
    with Program(tmp_path, "--source", "auto", "--no-panel") as program:
        program.until_said("no headset: the OpenXR runtime's service does not answer")
        program.until_recorded(5)
        program.send(signal.SIGINT)
        assert program.status() == 0


def test_with_a_service_the_headset_is_taken(runtime, screen, tmp_path):
    runtime(WOBBLING, UNSEEN).start()
    with Program(tmp_path, "--source", "auto", "--pictures", "3") as program:
        assert program.status() == 0
        assert "no headset" not in program.said
        assert "Monado" in program.recording.read_text(encoding="utf-8")
