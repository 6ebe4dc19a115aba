"""The head led by mouse and keys.

Where it goes, how smoothly, and that nobody's frame rate has a say in it.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hmdwarp.poses import Origin, Walker
from hmdwarp.poses.synth import (
    DEAF_NS,
    EYE_HEIGHT_M,
    FASTER,
    HORIZON_NS,
    KEPT_NS,
    STEEPEST_RAD,
    TURN_S,
    WALK_M_S,
    WALK_S,
)

MS = 1_000_000
BEGIN_NS = 123_456_789_012_345  # as large as a machine's clock gets

angle = st.floats(-1.0, 1.0)
axis = st.sampled_from((-1.0, 0.0, 1.0))
told = st.one_of(
    st.tuples(st.just("turn"), angle, angle),
    st.tuples(st.just("walk"), axis, axis, axis, st.booleans()),
    st.tuples(st.just("recentre")),
)
scripts = st.lists(st.tuples(st.integers(0, 300 * MS), told), max_size=12).map(
    lambda script: sorted(script, key=lambda one: one[0])
)


def tell(walker: Walker, time_ns: int, what: tuple) -> None:
    if what[0] == "walk":
        walker.walk(time_ns, *what[1:4], fast=what[4])
    else:
        getattr(walker, what[0])(time_ns, *what[1:])


def poses_at(script, rate_hz: float, wanted_ns: list[int]) -> list:
    """The pose at each of `wanted_ns` (relative, ascending), with the walker looked at `rate_hz`
    times a second besides.
    """
    walker, at = Walker(BEGIN_NS), 0
    polls = [round(k * 1e9 / rate_hz) for k in range(int(rate_hz) + 1)]
    events = [(t, 0, what) for t, what in script] + [(t, 1, None) for t in polls] + [(t, 2, None) for t in wanted_ns]
    events.sort(key=lambda event: event[:2])
    out = []
    for at, kind, what in events:
        if kind == 0:
            tell(walker, BEGIN_NS + at, what)
            continue
        walker.advance(BEGIN_NS + at)
        sample = walker.head_at(BEGIN_NS + at)
        out += [sample] if kind == 2 else []
    return out


@given(scripts)
@settings(max_examples=40)
def test_the_frame_rate_has_no_say_in_the_path(script):
    """The same inputs at the same instants.

    Bit for bit the same path, at 30, 144 and 1 frames a second.
    """
    wanted = [0, 7 * MS, 150 * MS, 333 * MS, 900 * MS]
    first, *others = (poses_at(script, rate, wanted) for rate in (30, 144, 1))
    for other in others:
        for a, b in zip(first, other, strict=True):
            assert a.pose.position_m.tolist() == b.pose.position_m.tolist()
            assert a.pose.orientation_xyzw.tolist() == b.pose.orientation_xyzw.tolist()


@given(scripts)
@settings(max_examples=40)
def test_never_rolls_never_tips_over_and_keeps_its_speed(script):
    samples = poses_at(script, 60, list(range(0, 600 * MS, 9 * MS)))
    jumps = {t for t, what in script if what[0] == "recentre"}
    for k, sample in enumerate(samples):
        right, up, back = sample.pose.rotation.as_matrix().T
        assert abs(right[1]) < 1e-12  # the horizon stays level
        assert up[1] > 0 and abs(math.asin(np.clip(-back[1], -1, 1))) <= STEEPEST_RAD + 1e-9
        if k and not any((k - 1) * 9 * MS <= t <= k * 9 * MS for t in jumps):
            way = np.abs(sample.pose.position_m - samples[k - 1].pose.position_m)
            fastest = FASTER * WALK_M_S * 0.009 + 1e-9  # no wish is longer than that, no lag overshoots
            assert math.hypot(way[0], way[2]) <= fastest and way[1] <= fastest


@pytest.mark.parametrize(
    ("told", "wanted"),
    [
        ({"forward": 1.0}, (0, 0, -1)),
        ({"right": 1.0}, (1, 0, 0)),
        ({"up": -1.0}, (0, -1, 0)),
        ({"right": -1.0, "forward": -1.0}, (-math.sqrt(0.5), 0, math.sqrt(0.5))),  # no faster askew
        ({"forward": 1.0, "fast": True}, (0, 0, -FASTER)),
    ],
)
def test_each_key_leads_where_it_says(told, wanted):
    """Level, along where the head has turned; off by e^(-0.9/0.08) * 0.08 * 4.2 m/s = 4e-6."""
    for yaw_deg, turned in ((0, wanted), (90, (wanted[2], wanted[1], -wanted[0]))):
        walker = Walker(0)
        walker.turn(0, math.radians(yaw_deg), math.radians(-60))
        walker.advance(1000 * MS)
        walker.walk(1000 * MS, **told)
        walker.advance(1900 * MS)
        got = walker.head_at(1900 * MS).pose.position_m - (0, EYE_HEIGHT_M, 0)
        assert got == pytest.approx(np.multiply(turned, WALK_M_S * (0.9 - WALK_S)), abs=3e-5)


def test_prediction_comes_true_without_further_input():
    walker = Walker(BEGIN_NS)
    walker.walk(BEGIN_NS, forward=1.0)
    walker.turn(BEGIN_NS + 10 * MS, 0.3, 0.1)
    now, then = BEGIN_NS + 21 * MS, BEGIN_NS + 21 * MS + HORIZON_NS
    walker.advance(now)
    expected = walker.head_at(then)
    assert expected.origin is Origin.PREDICTED and expected.time_ns == then and expected.read_ns == now
    walker.advance(then)
    came = walker.head_at(then)
    assert came.origin is Origin.MEASURED
    assert expected.pose.isclose(came.pose, atol=0)
    far = Walker(0)
    far.walk(0, forward=1.0)
    assert far.head_at(10_000 * MS).pose.isclose(far.head_at(HORIZON_NS).pose, atol=0)  # no further than 50 ms ahead


def test_past_is_remembered_for_a_quarter_of_a_second():
    walker, before = Walker(0), {}
    for t in range(0, 800, 5):
        walker.walk(t * MS, right=1.0 if t % 10 else -1.0)
        before[t] = walker.head_at(t * MS).pose
    for t in (795, 700, 620, 555):
        sample = walker.head_at(t * MS)
        assert sample.pose.isclose(before[t], atol=1e-15)
        assert sample.origin is (Origin.MEASURED if t == 795 else Origin.INTERPOLATED)
    long_ago = walker.head_at(0)
    assert long_ago.origin is Origin.HELD and long_ago.pose.isclose(before[795 - KEPT_NS // MS], atol=0)
    assert len(walker._states) == KEPT_NS // MS // 5 + 1


def test_a_program_that_was_stopped_does_not_walk_on():
    walker = Walker(0)
    walker.walk(0, forward=1.0)
    walker.advance(100 * MS)
    walker.advance(100 * MS + 3_600 * 10**9)  # an hour later
    assert -walker.head_at(100 * MS + 3_600 * 10**9).pose.position_m[2] < 2 * WALK_M_S * 0.1
    still = Walker(0)
    still.walk(0, forward=1.0)
    still.advance(DEAF_NS)
    assert -still.head_at(DEAF_NS).pose.position_m[2] > 0.9 * WALK_M_S * (1 - WALK_S)


def test_recentre_is_at_once_and_walking_goes_on():
    walker = Walker(0)
    walker.walk(0, forward=1.0)
    walker.turn(0, 2.0, 1.0)
    walker.advance(500 * MS)
    walker.recentre(500 * MS)
    sample = walker.head_at(500 * MS)
    assert sample.pose.position_m.tolist() == [0.0, EYE_HEIGHT_M, 0.0] and sample.pose.rotation.magnitude() == 0
    walker.advance(900 * MS)
    assert walker.head_at(900 * MS).pose.position_m[2] < -0.3


def test_an_input_from_before_counts_now():
    """Two sources of events with clocks of their own: nothing already shown changes."""
    walker = Walker(0)
    walker.advance(100 * MS)
    before = walker.head_at(100 * MS).pose
    walker.turn(50 * MS, 1.0, 0.0)
    assert walker.head_at(100 * MS).pose.isclose(before, atol=0)
    walker.advance(100 * MS + round(TURN_S * 1e9))
    turned = walker.head_at(100 * MS + round(TURN_S * 1e9)).pose.rotation.magnitude()
    assert turned == pytest.approx(1 - math.exp(-1), abs=1e-9)
