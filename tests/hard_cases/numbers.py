"""Hard numbers before any picture: quaternions, interpolation, time steps."""

from __future__ import annotations

import math

import numpy as np
import pytest

from hmdwarp.base import TraceError
from hmdwarp.geometry import Pose
from hmdwarp.poses import Origin, PoseTrack, angle_between, predict, slerp
from hmdwarp.poses.predictors import predictors

from .registry import hard_case


def about_y(angle: float) -> np.ndarray:
    """A turn by `angle` about the vertical, xyzw."""
    return np.array([0, math.sin(angle / 2), 0, math.cos(angle / 2)])


@hard_case("every pose between within 1e-9 rad of both", None)
def nearly_antipodal_quaternions():
    """Their dot product is -1: without the sign rule the head spins once round on the way."""
    a, b = about_y(0.5), -about_y(0.5 + 1e-9)
    track = PoseTrack(np.array([0, 10_000_000]), np.zeros((2, 3)), np.stack([a, b]))
    for t in range(0, 10_000_001, 1_000_000):
        assert angle_between(track.at(t).pose.orientation_xyzw, a) <= 1.1e-9
    assert Pose((0, 0, 0), a).towards(Pose((0, 0, 0), b), 0.5).isclose(Pose((0, 0, 0), a), 1e-9)


@hard_case("shares of the angle right to 1e-15 rad, unit length", None)
def slerp_over_a_hundred_millionth():
    """Sin of the angle is divided by itself; acos of a dot product that rounds to 1 is 0."""
    for share in (0.0, 0.25, 0.5, 1.0):
        got = np.array(slerp(about_y(1.0), about_y(1.0 + 1e-8), share))
        assert abs(float(angle_between(got, about_y(1.0))) - share * 1e-8) <= 1e-15
        assert abs(np.linalg.norm(got) - 1) <= 4e-16


@hard_case("finite, unit, on one of the two arcs, each share of it", None)
def slerp_over_a_half_turn():
    """Two arcs are equally short; sin of pi is not 0 in floating point."""
    for angle in (math.pi, np.nextafter(math.pi, 0), np.nextafter(math.pi, 4)):
        for share in (0.25, 0.5, 0.75):
            got = np.array(slerp(about_y(0), about_y(angle), share))
            assert abs(np.linalg.norm(got) - 1) <= 1e-15
            assert abs(float(angle_between(got, about_y(0))) - share * math.pi) <= 1e-7
            assert np.isfinite(
                Pose((0, 0, 0), about_y(0)).towards(Pose((0, 0, 0), about_y(angle)), share).orientation_xyzw
            ).all()


@hard_case("0 refused; 1 ns exact; the hour held, not invented; predictions finite", None)
def time_steps_of_nothing_a_nanosecond_and_an_hour():
    """0 divides by zero, 1 ns makes 1e9 m/s of a tremor, an hour is no motion to interpolate."""
    with pytest.raises(TraceError):
        PoseTrack(np.array([5, 5]), np.zeros((2, 3)), np.stack([about_y(0)] * 2))
    hour = 3_600_000_000_000
    times = np.array([0, 1, 2, hour])
    positions = np.outer([0, 1e-3, 0, 1], [1, 0, 0])
    track = PoseTrack(times, positions, np.stack([about_y(angle) for angle in (0, 1e-3, 0, 1)]))
    assert [track.at(int(t)).pose.position_m[0] for t in times] == [0, 1e-3, 0, 1]
    assert track.at(hour // 2).origin == Origin.HELD
    for method in predictors.names():
        for now in times:
            ahead = predict(track, int(now), int(now) + 50_000_000, method)
            assert np.isfinite(ahead.pose.position_m).all()
            assert np.isfinite(ahead.pose.orientation_xyzw).all()
