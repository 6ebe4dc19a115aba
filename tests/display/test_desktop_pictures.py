"""Where the eyes' pictures go in a window of any shape, what each view of a headset is, and when a
picture will be seen, told of swaps as screens of several kinds make them.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmdwarp.base import InputError
from hmdwarp.display.desktop import WindowView, choose_library
from hmdwarp.display.desktop.pacing import UNSYNCED, Pacer
from hmdwarp.display.desktop.window_system import flat_size, viewports, window_size
from hmdwarp.geometry import Pose
from hmdwarp.headsets import load_headset

sides = st.integers(1, 8000)
aspects = st.floats(0.2, 5)


@given(st.tuples(sides, sides), st.integers(1, 2), aspects)
def test_pictures_fill_the_window_as_far_as_their_aspect_lets_them(size, count, aspect):
    places = viewports(size, count, aspect)
    assert len(places) == count
    x, y, w, h = places[0]
    assert all(place == (x + k * w, y, w, h) for k, place in enumerate(places))  # side by side, equally large, no gap
    # In the middle within a pixel, and inside (a window narrower than its pictures has a pixel for
    # each still).
    right, above = size[0] - x - count * w, size[1] - y - h
    assert abs(right - x) <= 1 or size[0] < count
    assert 0 <= above - y <= 1
    assert abs(w - h * aspect) <= max(1, aspect) or min(w, h) == 1  # the aspect, within a pixel of either side
    # One of both directions is full; a narrow picture's height goes by its width in whole pixels,
    # of which each is worth 1 / aspect.
    assert right + x <= count or above + y <= 1 + 1 / aspect


@given(st.tuples(sides, sides), st.tuples(st.integers(200, 8000), st.integers(200, 8000)))
def test_a_new_window_fits_on_the_screen_and_is_no_stamp(wanted, room):
    w, h = window_size(wanted, room)
    assert w <= max(1, 0.9 * room[0] + 0.5) and h <= max(1, 0.9 * room[1] + 0.5)
    if w > 20 and h > 20:
        assert w / h == pytest.approx(wanted[0] / wanted[1], rel=0.05)  # half a pixel of 20 on each side


@pytest.mark.parametrize(
    ("wanted", "found"), [((192, 120), (768, 480)), ((1280, 800), (1280, 800)), ((2560, 1440), (1728, 972))]
)
def test_small_pictures_get_a_window_to_see_them_in_and_large_ones_keep_their_pixels(wanted, found):
    assert window_size(wanted, (1920, 1080)) == found


@given(aspects)
def test_the_flat_view_has_the_pixels_of_800x600(aspect):
    w, h = flat_size(aspect)
    assert w % 8 == h % 8 == 0
    assert w * h == pytest.approx(480_000, rel=0.03)  # four pixels of 310 or more on each side
    assert w / h == pytest.approx(aspect, rel=0.03)


@pytest.mark.parametrize("name", ["rift-dk1", "cardboard-v2", "flat-90"])
def test_views_of_a_headset(name):
    headset = load_headset(name)
    both, flat = WindowView("both", headset, None), WindowView("flat", headset, None)
    assert both.eyes is headset and both.headset is headset and both.size == headset.eye_size_px
    assert both.aspect == pytest.approx(both.size[0] / both.size[1], rel=0.01)
    assert both.total_size[0] == pytest.approx(2 * both.size[0], rel=0.01)
    head = Pose((1, 2, 3), (0, 0.6, 0, 0.8))
    (view,) = flat.eyes.views(head)
    assert view.pose is head and flat.headset is None
    left, right, down, up = view.fov.tangents
    assert (left, down) == (pytest.approx(-right), pytest.approx(-up))
    assert right == pytest.approx(np.abs(headset.eyes[0].fov.tangents[:2]).max())
    assert flat.aspect == pytest.approx(right / up) == pytest.approx(2 * both.aspect)  # fills the same window
    assert WindowView("flat", headset, (50, 40)).size == (50, 40)
    with pytest.raises(InputError, match="expected both or flat"):
        WindowView("left", headset, None)


@pytest.mark.parametrize(
    ("environ", "wanted"),
    [
        ({"DISPLAY": ":0", "XDG_SESSION_TYPE": "wayland"}, "x11"),
        ({"WAYLAND_DISPLAY": "wayland-0"}, "wayland"),
        ({"DISPLAY": ":0", "WAYLAND_DISPLAY": "wayland-0"}, "x11"),
        ({"DISPLAY": ":99", "PYGLFW_LIBRARY_VARIANT": "wayland"}, "wayland"),
    ],
)
def test_the_library_that_fits_the_display_is_taken(monkeypatch, environ, wanted):
    monkeypatch.setattr("os.environ", environ)
    choose_library()
    assert environ["PYGLFW_LIBRARY_VARIANT"] == wanted


MS = 1_000_000
PERIOD = round(1e9 / 60)


def run(pacer: Pacer, works_ms, screen) -> list[tuple[int, int]]:
    """Pictures that take so long each; screen(done) says when a swap asked for then is back.

    [(expected, seen)].
    """
    now, out = 5_000 * MS, []
    for work in works_ms:
        begun = max(now, pacer.due(now))
        expected = pacer.expect(begun)
        now = screen(begun + round(work * MS))
        pacer.swapped(begun, now)
        out.append((expected, now))
    return out


def at_vblank(done: int) -> int:
    return -(-done // PERIOD) * PERIOD


@pytest.mark.parametrize(("work_ms", "periods"), [(3, 1), (14, 1), (20, 2), (60, 4)])
def test_a_screen_that_is_waited_for_shows_the_picture_at_the_expected_refresh(work_ms, periods):
    """Exactly, once pictures of the same kind came before; a picture takes whole refreshes."""
    seen = run(Pacer(60, waits=True), [work_ms] * 40, at_vblank)
    assert all(abs(expected - at) <= 40 for expected, at in seen[2:])  # the period is rounded to whole ns
    assert seen[-1][1] - seen[-2][1] == pytest.approx(periods * PERIOD, abs=1)
    after_a_slow_one = run(Pacer(60, waits=True), [work_ms] * 20 + [90] + [work_ms] * 5, at_vblank)
    assert all(abs(expected - at) <= 40 for k, (expected, at) in enumerate(after_a_slow_one) if k > 1 and k != 20)


def test_pictures_that_take_longer_than_a_refresh_are_counted_as_missed():
    pacer = Pacer(60, waits=True)
    run(pacer, [5] * 10, at_vblank)
    assert pacer.missed() == 0
    run(pacer, [5, 5, 55, 5, 5], at_vblank)
    # The first of these comes after the clock was set back by `run`; 55 ms reach into the fourth
    # refresh.
    assert pacer.missed() == 3
    pacer.pause()  # which is no miss
    pacer.swapped(9_000_000 * MS, 9_000_004 * MS)
    assert pacer.missed() == 0


def test_without_waiting_a_picture_is_seen_when_it_is_done_and_half_a_refresh_later():
    seen = run(Pacer(60, waits=False), [7] * 20, int)
    assert all(expected == at + PERIOD // 2 for expected, at in seen[1:])
    assert not Pacer(60, waits=False).paced


def test_a_driver_that_does_not_wait_though_asked_is_waited_for():
    """llvmpipe, and drivers whose settings say "off".

    Pictures come at the screen's rate nevertheless.
    """
    pacer = Pacer(60, waits=True)
    seen = run(pacer, [2] * 60, int)
    assert pacer.paced
    gaps = np.diff([at for _, at in seen])
    assert (gaps[:UNSYNCED] == 2 * MS).all()
    assert gaps[UNSYNCED + 1 :] == pytest.approx(PERIOD, abs=1)
    pacer.set(60, waits=False)
    assert not pacer.paced
    pacer = Pacer(60, waits=True)
    run(pacer, [100] * 20, int)  # a slow software driver is not held up
    assert not pacer.paced and pacer.due(7) == 7


@given(st.floats(20, 500), st.lists(st.floats(0, 200), max_size=40), st.booleans(), st.booleans())
def test_no_picture_is_expected_before_it_is_begun_nor_held_back_for_more_than_a_period(rate, works, waits, obeys):
    pacer = Pacer(rate, waits)
    now, before = 10**15, 0
    for work in works:
        begun = pacer.due(now)
        assert now <= begun <= now + pacer.period_ns
        expected = pacer.expect(begun)
        assert expected >= begun and expected > before  # the link refuses to be asked about the past
        before = expected
        done = begun + round(work * MS)
        now = -(-done // pacer.period_ns) * pacer.period_ns if waits and obeys else done
        pacer.swapped(begun, now)
    assert pacer.missed() >= 0
