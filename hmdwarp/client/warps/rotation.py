"""Orientation-only reprojection: the homography of a pure turn."""

from __future__ import annotations

from typing import Literal

import attrs

from ...geometry import Pose, View, WarpMap
from ..warp_kinds import GatherSettings, HomographyWarp
from . import warps


@attrs.frozen
class RotationSettings(GatherSettings):
    """What is shown beyond the border of the rendered picture."""

    # clamp: its outermost pixels go on, so that no border is seen. Nothing counts as a hole then.
    edge: Literal["empty", "clamp"] = "empty"


@warps.register
class Rotation(HomographyWarp):
    """Rotate the picture with the head; ignore the eye's translation (asynchronous time warp)."""

    name = "rotation"
    needs_compute = False
    summary = "turns the picture with the head, ignores how the eye moved"
    exact_when = "the eye only turns, or everything is far away"
    gets_wrong = (
        "near things under translation: they stay glued to the far background; with edge=clamp, streaks where the "
        "rendered picture ends"
    )
    source = "van Waveren 2016, The Asynchronous Time Warp for Virtual Reality on Consumer Hardware"
    Settings = RotationSettings
    baselines = {"edge=clamp": "most streamers"}

    @property
    def clamps(self) -> bool:
        return bool(self.settings.edge == "clamp")

    def map_between(self, shown: View, rendered: View) -> WarpMap:
        return super().map_between(
            View(Pose(rendered.pose.position_m, shown.pose.orientation_xyzw), shown.fov), rendered
        )
