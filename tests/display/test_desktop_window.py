"""hmdwarp live in a real window of a virtual screen, led by a real mouse and keyboard, and what is
seen there; how it ends, with everything written.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from hmdwarp.poses import load_trace

from .programs import Live
from .virtual_screen import PATIENCE_S, VirtualScreen, needs_a_screen, until

pytestmark = [needs_a_screen, pytest.mark.slow]  # a program of its own, led by hand: 15 s

# of 255: what a still picture's mean may differ by between two looks (a title-long age changes a
# few pixels at edges)
NOISE = 6


@pytest.fixture(scope="module")
def screen(tmp_path_factory):
    with VirtualScreen(tmp_path_factory.mktemp("screen")) as made:
        yield made


@pytest.fixture(scope="module")
def live(screen, tmp_path_factory):
    """One run for most tests here: each leaves it as it found it."""
    with Live(screen, tmp_path_factory.mktemp("live")) as program:
        screen.do("mousemove", 300, 200)  # without a window manager, keys go where the mouse is
        # They are gone in seconds, before a busy machine looks: see contract.py.
        program.shows(lambda p: letters(p) == 0, "no first words any more")
        yield program


@pytest.fixture
def own_screen(tmp_path):
    """A screen for another run: without a window manager another window may lie over it."""
    (tmp_path / "screen").mkdir()
    with VirtualScreen(tmp_path / "screen") as made:
        made.do("mousemove", 300, 200)
        yield made


def letters(picture: np.ndarray) -> int:
    """How many pixels at the bottom are white."""
    return int((picture[-60:].min(axis=-1) > 240).sum())


def halves(picture: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    middle = picture.shape[1] // 2
    return picture[:, :middle], picture[:, middle:]


def lit(part: np.ndarray) -> float:
    """Share of pixels that are not black."""
    return float((part.max(axis=-1) > 8).mean())


def apart(one: np.ndarray, other: np.ndarray) -> float:
    """Mean difference of levels."""
    return float(np.abs(one.astype(int) - other).mean())


def flat_view(picture: np.ndarray) -> bool:
    return lit(picture) > 0.98


def test_both_eyes_are_side_by_side_behind_their_lenses(live):
    picture = live.shows(lambda p: lit(p) > 0.4, "two eyes' pictures")
    left, right = halves(picture)
    assert lit(left) == pytest.approx(lit(right), abs=0.02)  # both panels, mirrored
    assert abs(left.mean() - right.mean()) < NOISE
    assert apart(left, right) > 1  # and yet two eyes' views, not one twice
    for corner in (left[:8, :8], left[-8:, :8], right[:8, -8:], right[-8:, -8:]):
        assert lit(corner) == 0  # where the lens shows nothing
    h = picture.shape[0]
    sky, ground = left[h // 5 : h // 3, 100:250], left[2 * h // 3 : 4 * h // 5, 100:250]
    assert sky[..., 2].mean() > sky[..., 0].mean() + 20  # blue above, in this order of colours
    assert abs(ground[..., 2].mean() - ground[..., 0].mean()) < 20 and sky.mean() > ground.mean() - 60


def test_keys_change_what_the_title_tells(live):
    live.titled("spheres - forward + ", " 50 ms")
    for keys, title in (
        (("bracketright", "bracketright"), " 150 ms"),
        (("bracketleft", "bracketleft"), " 50 ms"),
        (("t",), "spheres - forward_ordered + "),
        (("shift+t",), "spheres - forward + "),
        (("n",), "- forward + "),
    ):
        live.press(*keys)
        live.titled(title)
    until(lambda: "spheres" not in live.title, "another scene")
    live.press("shift+n")
    live.titled("spheres - forward + ", "age ")


def test_flat_view_and_resizing_keep_the_shape_in_black(live):
    live.press("v")
    flat = live.shows(flat_view, "one flat view")
    assert flat.shape[:2] == (480, 768)  # all of it, as both eyes did
    live.screen.do("windowsize", live.window, 400, 700)
    tall = live.shows(lambda p: p.shape[:2] == (700, 400) and lit(p) > 0.3 > lit(p[:90]) == lit(p[-90:]), "a tall one")
    assert lit(tall[:90]) == 0
    rows = np.flatnonzero(tall.max(axis=(1, 2)) > 8)
    assert len(rows) == pytest.approx(400 / 1.6, abs=2)
    live.screen.do("windowsize", live.window, 768, 480)
    live.press("v")
    live.shows(lambda p: p.shape[:2] == (480, 768) and min(map(lit, halves(p))) > 0.4, "both eyes again")


def test_full_screen_and_back_to_the_same_place(live):
    x, y, *_ = live.geometry
    live.screen.do("windowmove", live.window, 60, 40)
    before = until(lambda: live.geometry if live.geometry[:2] == (60, 40) else None, "the window moved")
    for place in ((0, 0, *live.screen.size), before):
        live.press("F11")
        until(lambda place=place: live.geometry == place, f"{place}")
    live.screen.do("windowmove", live.window, x, y)


def test_mouse_turns_once_caught_and_escape_lets_it_go(live):
    live.press("v")
    live.shows(flat_view, "one flat view")
    before = live.picture()
    live.screen.do("mousemove", 320, 240)
    live.screen.do("mousemove_relative", 80, 0)
    live.screen.do("sleep", 0.5)
    assert apart(live.picture(), before) < NOISE  # not caught yet
    live.screen.do("click", 1)
    _, _, w, h = live.geometry
    until(lambda: f"x:{w // 2} y:{h // 2} " in live.screen.do("getmouselocation"), "a caught mouse, in the middle")
    live.screen.do("mousemove_relative", 60, 0)  # 6 degrees to the right
    live.shows(lambda p: shift(before, p) < -8, "another direction")
    turned = settled(live)
    # 6 degrees are tan(6 deg) / 2.185 of the picture's width in its middle; what is there moves to
    # the left.
    assert shift(before, turned) == pytest.approx(-768 * np.tan(np.radians(6)) / (2 * 1.0924), abs=4)
    live.press("Escape", "r")
    live.shows(lambda p: apart(p, before) < NOISE, "the first view again")
    live.press("v")


def settled(live: Live) -> np.ndarray:
    """A picture that no longer changes."""
    pictures = [live.picture()]

    def still() -> bool:
        live.screen.do("sleep", 0.3)
        pictures.append(live.picture())
        return apart(*pictures[-2:]) < 0.2

    until(still, "a picture at rest")
    return pictures[-1]


def shift(before: np.ndarray, after: np.ndarray) -> int:
    """By how many pixels to the right the middle of the picture went."""
    h, w = before.shape[:2]
    rows, middle = slice(h // 4, 3 * h // 4), w // 2

    def off(by: int) -> float:
        return apart(after[rows, middle - 80 + by : middle + 80 + by], before[rows, middle - 80 : middle + 80])

    return min(range(-60, 61), key=off)


def test_keys_and_mouse_act_in_a_scene_and_the_recorder_keeps_it(own_screen, tmp_path):
    """Ahead at the start: the switch 13 degrees off, and the cupboard's handle 11."""
    written, do = tmp_path / "head.input.csv", own_screen.do

    def done() -> list[str]:
        lines = written.read_text().splitlines()[1:] if written.exists() else []
        return [" ".join(line.split(",")[1:3]) for line in lines]

    written.write_text("of a recording before\n")
    with Live(own_screen, tmp_path, "--scene", "playroom", "--record", "head.csv", "--force") as program:
        program.shows(lambda p: lit(p) > 0.4, "the scene, which has no hand before")
        program.press("l")
        until(lambda: done() == ["switch lamp"], "the lamp's switch")
        do("click", 1)  # catches the mouse, and does nothing else
        do("click", 2)
        until(lambda: done()[1:] == ["switch lamp"], "the switch by mouse")
        do("mousedown", 3)
        until(lambda: done()[2:] == ["grab door"], "a grab, which is no news while the head is still")
        do("mousemove_relative", "--", -60, 0)
        until(lambda: len(done()) > 3 and {*done()[2:]} == {"grab door"}, "a hand that follows the head")
        do("mouseup", 3)
        until(lambda: done()[-1] == "release door", "a hand that lets go")
        do("click", 1)
        until(lambda: done()[-1] == "push door", "a push by mouse")
        program.press("Escape")  # lets the mouse go
        do("sleep", 0.5)
        assert "fps" in program.title
        program.press("Escape")
        status, told = program.ended()
    assert status == 0 and f"{len(done())} inputs" in told and "Traceback" not in told


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


def test_minimised_it_waits_and_comes_back_and_a_click_on_the_cross_ends_it(own_screen, tmp_path):
    """Meanwhile it hardly uses the processor, of which it takes all of one otherwise."""

    def cpu_s() -> float:
        fields = Path(f"/proc/{live.pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def waits() -> bool:
        began = cpu_s()
        own_screen.do("sleep", 1.5)
        return cpu_s() - began < 0.5

    with Live(own_screen, tmp_path, "--record", "head.csv", "--out", "out") as live:
        live.until_recorded(20)  # the first, of pictures that were slow, may be a nanosecond apart
        as_manager(live, STATE, state=3)
        live.until(waits, "a program that hardly works")
        as_manager(live, STATE, state=1)
        live.press("bracketright")
        live.titled(" 100 ms")
        as_manager(live, DELETE)
        status, told = live.ended()
    assert status == 0 and "the window was closed" in told and "Traceback" not in told
    assert (tmp_path / "out" / "summary.json").is_file()
    assert len(load_trace(live.recording).track.time_ns) >= 20
