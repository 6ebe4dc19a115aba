"""How fast the head goes, from one shown pose to the next."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ...pipeline.loop import Refresh

_APART_NS = 500_000_000  # a picture after a longer break says nothing of the way there
Speeds = tuple[float | None, float | None]


def speeds_between(before: Refresh | None, now: Refresh) -> Speeds:
    """Angular speed in deg/s and linear speed in m/s over the time between two pictures; None for the first and after a break."""
    if before is None or not 0 < now.shown_ns - before.shown_ns <= _APART_NS:
        return None, None
    seconds = (now.shown_ns - before.shown_ns) * 1e-9
    a, b = before.head.pose, now.head.pose
    turned = angle_between(a.orientation_xyzw.tolist(), b.orientation_xyzw.tolist())
    return math.degrees(turned) / seconds, math.dist(a.position_m.tolist(), b.position_m.tolist()) / seconds


def angle_between(a: Sequence[float], b: Sequence[float]) -> float:
    """`poses.quaternions.angle_between` of two, in plain floats: 1 us instead of 20."""
    apart, together = math.dist(a, b), math.dist(a, [-value for value in b])
    return 4 * math.atan2(min(apart, together), max(apart, together))
