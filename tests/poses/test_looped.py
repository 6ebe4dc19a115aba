"""A recording that goes on for as long as anybody looks."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from hmdwarp.poses import LoopedSource, folded, synthesise

TRACK = synthesise("walk", seed=1, seconds=1)


class Clock:
    now_ns = 0

    def __call__(self) -> int:
        return self.now_ns


@given(st.integers(-(10**12), 10**13), st.integers(1, 10**11))
def test_time_stays_inside_and_never_jumps(since_ns, length_ns):
    here, next_ = (folded(at, length_ns).since_ns for at in (since_ns, since_ns + 1))
    assert 0 <= here <= length_ns
    assert abs(next_ - here) <= 1
    assert folded(since_ns + 2 * length_ns, length_ns).since_ns == here or since_ns < 0


def test_the_first_time_through_it_is_the_track_and_then_its_mirror_image():
    source, track = LoopedSource(TRACK, Clock()), TRACK
    for after_ns in (0, 1, 123_456_789, track.duration_ns):
        expected = track.at(track.start_ns + after_ns).pose
        for asked_ns in (after_ns, 2 * track.duration_ns - after_ns, 2 * track.duration_ns + after_ns):
            sample = source.head_at(asked_ns)
            assert sample.time_ns == asked_ns
            assert np.array_equal(sample.pose.position_m, expected.position_m)
            assert np.array_equal(sample.pose.orientation_xyzw, expected.orientation_xyzw)


def test_restart_begins_anew():
    clock = Clock()
    source = LoopedSource(TRACK, clock)
    clock.now_ns = 700_000_000
    source.restart()
    sample = source.head_at(clock.now_ns)
    assert np.array_equal(sample.pose.position_m, TRACK.pose(0).position_m)
    assert sample.read_ns == clock.now_ns
