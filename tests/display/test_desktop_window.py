"""hmdwarp live in a real window of a virtual screen, led by a real mouse and keyboard, and what is
seen there.
"""

from __future__ import annotations

import numpy as np
import pytest

from .programs import SMALL, Live
from .virtual_screen import VirtualScreen, needs_a_screen, until

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
    """One run for all tests here: each leaves it as it found it."""
    with Live(screen, tmp_path_factory.mktemp("live"), *SMALL) as program:
        screen.do("mousemove", 300, 200)  # without a window manager, keys go where the mouse is
        # They are gone in seconds, before a busy machine looks: see contract.py.
        program.shows(lambda p: letters(p) == 0, "no first words any more")
        yield program


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


def test_the_help_is_laid_over_the_left_eye_and_taken_away(live):
    before = live.picture()
    for closes in ("h", "Escape"):  # which ends nothing then
        live.press("h")
        shown = live.shows(lambda p: (halves(p)[0].min(axis=-1) > 200).mean() > 0.02, "white letters")
        assert apart(halves(shown)[1], halves(before)[1]) < NOISE
        live.press(closes)
        live.shows(lambda p: apart(p, before) < NOISE, "no help")


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


def test_keys_and_mouse_act_in_a_scene_and_the_recorder_keeps_it(tmp_path):
    """Ahead at the start: the switch 13 degrees off, and the cupboard's handle 11.

    On a screen of its own: without a window manager another window may lie over it.
    """
    written = tmp_path / "head.input.csv"

    def done() -> list[str]:
        lines = written.read_text().splitlines()[1:] if written.exists() else []
        return [" ".join(line.split(",")[1:3]) for line in lines]

    where = (*SMALL[:4], "--scene", "playroom", *SMALL[6:], "--record", "head.csv", "--force")
    written.write_text("of a recording before\n")
    with VirtualScreen(tmp_path) as screen, Live(screen, tmp_path, *where) as program:
        screen.do("mousemove", 300, 200)
        program.shows(lambda p: lit(p) > 0.4, "the scene, which has no hand before")
        program.press("l")
        until(lambda: done() == ["switch lamp"], "the lamp's switch")
        screen.do("click", 1)  # catches the mouse, and does nothing else
        screen.do("click", 2)
        until(lambda: done()[1:] == ["switch lamp"], "the switch by mouse")
        screen.do("mousedown", 3)
        until(lambda: done()[2:] == ["grab door"], "a grab, which is no news while the head is still")
        screen.do("mousemove_relative", "--", -60, 0)
        until(lambda: len(done()) > 3 and {*done()[2:]} == {"grab door"}, "a hand that follows the head")
        screen.do("mouseup", 3)
        until(lambda: done()[-1] == "release door", "a hand that lets go")
        screen.do("click", 1)
        until(lambda: done()[-1] == "push door", "a push by mouse")
        program.press("Escape", "Escape")
        status, told = program.ended()
    assert status == 0 and f"{len(done())} inputs" in told


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
