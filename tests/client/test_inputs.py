"""What passes are given of a display that lights up row by row.

Its first and last instant; the middle for those that cannot follow.
"""

from __future__ import annotations

import pytest
from hypothesis import given
from replays import each_refresh, small
from strategies import FOVS, poses

from hmdwarp.client import PassInputs
from hmdwarp.errors import InputError
from hmdwarp.geometry import View


def given_of(first: View, last: View | None) -> PassInputs:
    return PassInputs(None, first, shown_last=last)  # type: ignore[arg-type]  # the rendered picture plays no part here


@given(poses(), poses(), FOVS)
def test_the_middle_is_half_way(first, last, fov):
    both = given_of(View(first, fov), View(last, fov))
    assert both.middle.pose.isclose(first.towards(last, 0.5), 1e-12)
    assert both.middle.fov == fov


@given(poses(), poses(), FOVS)
def test_at_once_shows_the_middle_and_nothing_later(first, last, fov):
    both = given_of(View(first, fov), View(last, fov))
    at_once = both.at_once()
    assert at_once.shown_last is None
    assert at_once.shown.pose.isclose(both.middle.pose, 0)
    assert at_once.middle is at_once.shown
    assert at_once.at_once() is at_once


@given(poses(), FOVS)
def test_a_display_that_lights_up_at_once_stays_as_it_is(pose, fov):
    one = given_of(View(pose, fov), None)
    assert one.middle is one.shown
    assert one.at_once() is one


@pytest.mark.parametrize(
    ("warp", "follow", "follows"), [("rotation", True, True), ("rotation", False, False), ("forward", True, False)]
)
def test_the_loop_asks_for_the_head_at_both_ends_of_the_scan_out(warp, follow, follows):
    options = small(warp=warp, trace="fast-turns", seconds=0.1, scanout_ms=12.0, follow_scanout=follow)
    turned = []

    def look(setup, number, refresh):
        assert setup.plans[0].scanout is follows
        first, last = (setup.track.at(refresh.shown_ns + ns).pose for ns in (0, 12_000_000))
        for eye, one in enumerate(refresh.inputs):
            assert one.shown.pose.isclose(setup.source.headset.views(first)[eye].pose, 1e-12)
            assert one.shown_last.pose.isclose(setup.source.headset.views(last)[eye].pose, 1e-12)
            assert refresh.eyes[eye].view.pose.isclose(one.middle.pose, 1e-12)
        turned.append((first.rotation.inv() * last.rotation).magnitude())

    each_refresh(options, look)
    assert max(turned) > 0, "then this shows nothing"


def test_a_scan_out_backwards_in_time_is_refused():
    with pytest.raises(InputError, match="scanout"):
        small(scanout_ms=-1.0)
