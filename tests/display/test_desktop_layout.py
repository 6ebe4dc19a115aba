"""Where the eyes' pictures go in a window of any shape, and what each view of a headset is."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmdwarp.display.desktop import WindowView, choose_library
from hmdwarp.display.desktop.window_system import flat_size, viewports, window_size
from hmdwarp.errors import InputError
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
