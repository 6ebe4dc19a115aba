"""Image deflection: the whole picture moves by one offset."""

from __future__ import annotations

import numpy as np

from ...geometry import View, WarpMap
from ..warp_kinds import HomographyWarp
from . import warps


@warps.register
class Shift(HomographyWarp):
    """Move the picture so that the middle of the view is where the head's turn puts it."""

    name = "shift"
    needs_compute = False
    summary = "moves the picture by one offset, that of the middle of the view"
    exact_when = "the head is still"
    gets_wrong = "roll, how a turn stretches the picture towards its border, and all that rotation gets wrong"
    source = "So and Griffin 1992, Compensating Lags in Head-Coupled Displays Using Head Position Prediction and "
    source += "Image Deflection; the 2014 thesis, section 2.4"

    def map_between(self, shown: View, rendered: View) -> WarpMap:
        """Return the translation; where the middle lies behind the rendered eye, w < 0."""
        left, right, down, up = shown.fov.tangents
        middle = np.array([(left + right) / 2, (down + up) / 2, -1.0])
        to = (rendered.pose.rotation.inv() * shown.pose.rotation).apply(middle)
        offset = to[:2] / abs(to[2]) - middle[:2]
        moved = np.array([[1.0, 0, offset[0]], [0, 1, offset[1]], [0, 0, 1 if to[2] < 0 else -1]])
        into = rendered.fov.pixel_from_tangent(self.rendered_size)
        return WarpMap(into @ moved @ np.linalg.inv(shown.fov.pixel_from_tangent(self.shown_size)), np.zeros(3))
