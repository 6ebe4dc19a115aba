"""Head speed: around an instant of a trace, or between two shown poses."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..pipeline.loop import Refresh
from ..poses import PoseTrack, quaternions

_HALF_NS = 5_000_000
_APART_NS = 500_000_000  # after a longer break the speed between two pictures is meaningless
Speeds = tuple[float | None, float | None]


def speeds_at(track: PoseTrack, time_ns: int) -> Speeds:
    """Return angular speed in deg/s and linear speed in m/s, by central differences over 10 ms."""
    before, after = track.at(time_ns - _HALF_NS).pose, track.at(time_ns + _HALF_NS).pose
    turned = quaternions.angle_between(before.orientation_xyzw, after.orientation_xyzw)
    seconds = 2 * _HALF_NS * 1e-9
    return float(np.degrees(turned) / seconds), float(np.linalg.norm(after.position_m - before.position_m) / seconds)


def speeds_between(before: Refresh | None, now: Refresh) -> Speeds:
    """Return both speeds over the time between two pictures.

    None for the first picture and after a break.
    """
    if before is None or not 0 < now.shown_ns - before.shown_ns <= _APART_NS:
        return None, None
    seconds = (now.shown_ns - before.shown_ns) * 1e-9
    a, b = before.head.pose, now.head.pose
    turned = angle_between(a.orientation_xyzw.tolist(), b.orientation_xyzw.tolist())
    return math.degrees(turned) / seconds, math.dist(a.position_m.tolist(), b.position_m.tolist()) / seconds


def angle_between(a: Sequence[float], b: Sequence[float]) -> float:
    """Return `poses.quaternions.angle_between` of two, in plain floats: 1 us instead of 20."""
    apart, together = math.dist(a, b), math.dist(a, [-value for value in b])
    return 4 * math.atan2(min(apart, together), max(apart, together))
