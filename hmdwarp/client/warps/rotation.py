"""Orientation-only reprojection: the homography of a pure turn."""

from __future__ import annotations

from ...geometry import Pose, View, WarpMap
from ..warp_kinds import HomographyWarp
from . import warps


@warps.register
class Rotation(HomographyWarp):
    """Rotate the picture with the head; ignore the eye's translation (asynchronous time warp)."""

    name = "rotation"
    needs_compute = False
    summary = "turns the picture with the head, ignores how the eye moved"
    exact_when = "the eye only turns, or everything is far away"
    gets_wrong = "near things under translation: they stay glued to the far background"
    source = "van Waveren 2016, The Asynchronous Time Warp for Virtual Reality on Consumer Hardware"

    def map_between(self, shown: View, rendered: View) -> WarpMap:
        return super().map_between(
            View(Pose(rendered.pose.position_m, shown.pose.orientation_xyzw), shown.fov), rendered
        )
