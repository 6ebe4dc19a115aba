"""What passes are given: the instants of a scan-out, and the older frames that are kept."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from replays import each_refresh, small
from strategies import FOVS, poses

from hmdwarp.base import InputError
from hmdwarp.client import History, PassInputs
from hmdwarp.frames import Frame, Others
from hmdwarp.geometry import View


def given_of(first: View, last: View | None) -> PassInputs:
    return PassInputs(None, first, shown_last=last)  # type: ignore[arg-type]  # the rendered picture plays no part here


@given(poses(), poses(), FOVS)
def test_at_once_shows_the_view_half_way_and_nothing_later(first, last, fov):
    both, one = (given_of(View(first, fov), end) for end in (View(last, fov), None))
    at_once = both.at_once()
    assert both.middle.pose.isclose(first.towards(last, 0.5), 1e-12) and both.middle.fov == fov
    assert at_once.shown_last is None and at_once.shown.pose.isclose(both.middle.pose, 0)
    for each in (at_once, one):  # a display that lights up at once stays as it is
        assert each.middle is each.shown and each.at_once() is each


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


MS = 1_000_000
# Instants in the order in which frames are replaced: never backwards, now and then the same again.
INSTANTS = st.lists(st.integers(0, 60), max_size=40).map(
    lambda steps: [sum(steps[:n]) * MS for n in range(1, len(steps) + 1)]
)
KEEPS, SPACINGS = st.integers(0, 5), st.sampled_from([0, 1, 16 * MS, 100 * MS])


def frame(drawn_ns: int) -> Frame:
    return Frame((), drawn_ns, ())


@given(KEEPS, SPACINGS, KEEPS, INSTANTS)
def test_held_frames_keep_within_the_limits(keep, spacing_ns, recent, instants):
    history = History(Others(keep, spacing_ns, recent=recent), lambda _: None)
    for count, now in enumerate(instants, start=1):
        history.offer(frame(now))
        held = [frame.drawn_ns for frame in history.frames]
        assert len(held) <= keep
        assert held == sorted(held, reverse=True), "newest first"
        assert all(newer - older >= spacing_ns for newer, older in zip(held, held[1:], strict=False))
        assert keep == 0 or held[0] > now - max(spacing_ns, 1), (
            "the newest held one is no older than the spacing allows"
        )
        assert [frame.drawn_ns for frame in history.recent] == instants[:count][::-1][:recent]


@given(KEEPS, SPACINGS, KEEPS, INSTANTS)
def test_every_offered_frame_is_held_or_given_back_once(keep, spacing_ns, recent, instants):
    discarded: list[Frame] = []
    history = History(Others(keep, spacing_ns, recent=recent), discarded.append)
    offered = []
    for now in instants:
        offered.append(frame(now))
        history.offer(offered[-1])
        assert sorted({*map(id, [*discarded, *history.frames, *history.recent])}) == sorted(map(id, offered))
    history.close()
    assert history.frames == history.recent == ()
    assert sorted(map(id, discarded)) == sorted(map(id, offered))
    history.close()
    assert len(discarded) == len(offered), "closing twice gives nothing back twice"
