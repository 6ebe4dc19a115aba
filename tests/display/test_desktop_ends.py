"""How a run in a window ends: by keys and by the window manager.

Each with status 0 and everything written.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from hmdwarp.poses import load_trace

from .programs import SMALL, Live
from .virtual_screen import PATIENCE_S, VirtualScreen, needs_a_screen, until

pytestmark = [needs_a_screen, pytest.mark.slow]  # programs of their own: 15 s
SIZE = (900, 600)


@pytest.fixture
def screen(tmp_path):
    folder = tmp_path / "screen"
    folder.mkdir()
    with VirtualScreen(folder, SIZE) as made:
        made.do("mousemove", 100, 100)  # without a window manager, keys go where the mouse is
        yield made


# What a window manager does, and xdotool does not.
AS_MANAGER = """
import ctypes
x = ctypes.CDLL("libX11.so.6")
x.XOpenDisplay.restype, x.XInternAtom.restype = ctypes.c_void_p, ctypes.c_ulong
display = ctypes.c_void_p(x.XOpenDisplay(None))
atom = lambda name: ctypes.c_ulong(x.XInternAtom(display, name, 0))
{}
x.XCloseDisplay(display)
"""
# ICCCM 4.2.8.1: what a click on the cross sends.
DELETE = """
class Message(ctypes.Structure):
    _fields_ = [("type", ctypes.c_int), ("serial", ctypes.c_ulong), ("sent", ctypes.c_int),
                ("display", ctypes.c_void_p), ("window", ctypes.c_ulong), ("kind", ctypes.c_ulong),
                ("format", ctypes.c_int), ("data", ctypes.c_long * 20)]
message = Message(33, 0, 1, display, {window}, atom(b"WM_PROTOCOLS"), 32)
message.data[0] = atom(b"WM_DELETE_WINDOW").value
x.XSendEvent(display, ctypes.c_ulong({window}), 0, 0, ctypes.byref(message))
"""
# ICCCM 4.1.3.1: 3 is iconic, 1 normal.
STATE = """
kind = atom(b"WM_STATE")
x.XChangeProperty(display, ctypes.c_ulong({window}), kind, kind, 32, 0, (ctypes.c_long * 2)({state}, 0), 2)
"""


def as_manager(live: Live, program: str, **values: object) -> None:
    command = [sys.executable, "-c", AS_MANAGER.format(program.format(window=live.window, **values))]
    subprocess.run(command, check=True, env=live.screen.environment, timeout=PATIENCE_S)


ENDS = {
    "cross": (lambda live: as_manager(live, DELETE), "the window was closed"),
    "ctrl-c": (lambda live: live.send(signal.SIGINT), ""),
}


@pytest.mark.parametrize("how", ENDS)
def test_it_ends_with_everything_written(screen, tmp_path, how):
    end, words = ENDS[how]
    with Live(screen, tmp_path, *SMALL, "--record", "head.csv", "--out", "out") as live:
        live.until_recorded(20)  # the first, of pictures that were slow, may be a nanosecond apart
        end(live)
        status, told = live.ended()
    assert status in ((0, 130) if how == "ctrl-c" else (0,)) and words in told and "Traceback" not in told
    assert (tmp_path / "out" / "summary.json").is_file()
    assert len(load_trace(live.recording).track.time_ns) >= 20


def test_escape_twice_lets_go_and_ends_and_the_walk_is_recorded(screen, tmp_path):
    """W is 1.4 m/s ahead, level; the recording has it."""
    with Live(screen, tmp_path, *SMALL, "--view", "flat", "--record", "head.csv") as live:
        before = live.shows(lambda p: p.max() > 100, "a picture")
        screen.do("keydown", "w")
        live.shows(lambda p: grown(before, p) > 1, "what is ahead, nearer")
        screen.do("keyup", "w", "sleep", 1, "click", 1)
        live.press("Escape")  # lets the mouse go
        screen.do("sleep", 0.5)
        assert "fps" in live.title
        live.press("Escape")
        status, told = live.ended()
    assert status == 0 and "the window was closed" in told and "Traceback" not in told
    track = load_trace(live.recording).track
    way = track.position_m[-1] - track.position_m[0]
    assert way[2] < -0.1 and abs(way[0]) < 1e-9 and abs(way[1]) < 1e-9
    # Keys are looked at once a picture, and poses are of when it will be seen: one interval more.
    (steps,) = np.diff(track.position_m[:, 2]).nonzero()
    times_s = 1e-9 * track.time_ns[steps[0] : steps[-1] + 2]
    assert -way[2] <= 1.4 * (times_s[-1] - times_s[0] + np.diff(times_s).max())


def grown(before: np.ndarray, after: np.ndarray) -> float:
    """The enlargement about the middle, of a few, by which `before` is most like `after`."""
    h, w = before.shape[:2]
    y, x = np.mgrid[h // 4 : 3 * h // 4, 2 * w // 5 : 3 * w // 5]

    def apart(factor: float) -> float:
        there = before[((y - h / 2) / factor + h / 2).astype(int), ((x - w / 2) / factor + w / 2).astype(int)]
        return float(np.abs(there.astype(int) - after[y, x]).mean())

    return min((0.7, 0.85, 1.0, 1.2, 1.4, 1.7), key=apart)


def test_minimised_it_waits_and_comes_back(screen, tmp_path):
    """Meanwhile it hardly uses the processor, of which it takes all of one otherwise."""

    def cpu_s() -> float:
        fields = Path(f"/proc/{live.pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def waits() -> bool:
        began = cpu_s()
        screen.do("sleep", 1.5)
        return cpu_s() - began < 0.5

    with Live(screen, tmp_path, *SMALL) as live:
        as_manager(live, STATE, state=3)
        live.until(waits, "a program that hardly works")
        as_manager(live, STATE, state=1)
        live.press("bracketright")
        live.titled(" 100 ms")


def test_full_screen_and_back_to_the_same_place(screen, tmp_path):
    with Live(screen, tmp_path, *SMALL) as live:
        screen.do("windowmove", live.window, 60, 40)
        before = until(lambda: live.geometry if live.geometry[:2] == (60, 40) else None, "the window moved")
        live.press("F11")
        until(lambda: live.geometry == (0, 0, *SIZE), "full screen")
        live.press("F11")
        until(lambda: live.geometry == before, "the old place")
        live.press("Escape")
        status, told = live.ended()
    assert status == 0 and "Traceback" not in told
