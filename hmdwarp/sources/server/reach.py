"""Where the head may be before a frame is seen, and what it may see from there."""

from __future__ import annotations

import math
from collections import deque

import numpy as np
from numpy.typing import NDArray

from ...geometry import View
from .projection import boxes_of, clip_from_eye, eye_from_scene, side_planes, visible

Array = NDArray[np.float64]
# From sending to the news of the arrival, until the first news says it.
FIRST_ROUND_TRIP_NS = 200_000_000
# The head's speed is the fastest between two of so many frames.
FRAMES = 16
# An eye that is this near to a piece, or inside, sees all of it.
NEAREST_M = 0.1


class Head:
    """How fast the head has moved of late."""

    def __init__(self) -> None:
        self._seen: deque[tuple[int, View]] = deque(maxlen=FRAMES)

    def see(self, view: View, now_ns: int) -> None:
        """Take the view of a frame."""
        if not self._seen or now_ns > self._seen[-1][0]:
            self._seen.append((now_ns, view))

    def reach(self, within_ns: int) -> tuple[float, float]:
        """Return metres and radians that it may move by within that time."""
        metres = radians = 0.0
        for (before_ns, before), (now_ns, now) in zip(self._seen, list(self._seen)[1:], strict=False):
            times = within_ns / (now_ns - before_ns)
            metres = max(metres, times * float(np.linalg.norm(now.pose.position_m - before.pose.position_m)))
            turned = before.pose.angle_to(now.pose)
            radians = max(radians, min(times * turned, math.pi))
        return metres, radians


def may_be_seen(
    centres: Array, halves: Array, view: View, origin_m: Array, metres: float, radians: float
) -> NDArray[np.bool_]:
    """Return which boxes may be visible to an eye that moves and turns by no more than that.

    centres, halves: (n, 3) relative to `origin_m`. As Visibility, whose slack this is.
    """
    clip = clip_from_eye(view.fov)
    steep = np.linalg.norm(side_planes(clip)[:, :3], axis=1)
    reach = np.linalg.norm(centres - (view.pose.position_m - origin_m), axis=1)
    reach += np.linalg.norm(halves, axis=1)
    slack = steep[:, None] * (radians * reach + metres)
    return visible(boxes_of(centres, halves), clip @ eye_from_scene(view, origin_m), slack)
