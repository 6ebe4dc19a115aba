"""No warp at all: what a headset shows without compensation."""

from __future__ import annotations

from ...geometry import View, WarpMap
from . import warps
from ._homography import HomographyWarp


@warps.register
class NoWarp(HomographyWarp):
    """The late picture at the same place in the field of view, as if the head had not moved (a guard band is cut off)."""

    name = "none"
    summary = "the late picture as it is: what uncompensated latency looks like"
    exact_when = "the head is still"
    gets_wrong = "everything that moves relative to the head"
    source = "the baseline of every comparison"

    def relative_map(self, late: View, shown: View) -> WarpMap:
        return WarpMap.between(View(late.pose, shown.fov), self.shown_size, late, self.late_size)
