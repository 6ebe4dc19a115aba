"""No warp: the picture of a headset without compensation."""

from __future__ import annotations

from ...geometry import View, WarpMap
from ...options import NoSettings
from ..warp_kinds import HomographyWarp
from . import warps


@warps.register
class NoWarp(HomographyWarp):
    """Show the rendered picture at its place in the field of view, as if the head had not moved.

    A guard band is cut off.
    """

    name = "none"
    needs_compute = False
    Settings = NoSettings
    summary = "the rendered picture as it is: what uncompensated latency looks like"
    exact_when = "the head is still"
    gets_wrong = "everything that moves relative to the head"
    source = "the baseline of every comparison"
    imposter = True

    def map_between(self, shown: View, rendered: View) -> WarpMap:
        return super().map_between(View(rendered.pose, shown.fov), rendered)
