"""Forward warping without depth comparison: the epipole decides which surface is in front."""

from __future__ import annotations

from typing import Literal

import attrs
import numpy as np
from numpy.typing import NDArray

from ...geometry import view_map
from ..inputs import PassInputs
from ..warp_kinds import OrderedScatter
from . import warps

# Pixels from the picture's middle beyond which an epipole counts as this far in its direction: rows
# of the largest picture then turn by at most 2^14 / 2^20 rad against the true lines, a pixel in 64,
# and the distance still fits into an integer.
FARTHEST = 2.0**20


@attrs.frozen
class ForwardOrderedSettings:
    """The order in which rendered pixels are visited."""

    # rings: squares around the epipole, so that pixels of similar distance are compared. rows:
    # McMillan's quadrants, row by row.
    sheets: Literal["rings", "rows"] = attrs.field(default="rings", validator=attrs.validators.in_(("rings", "rows")))


@warps.register
class ForwardOrdered(OrderedScatter):
    """Scatter pixels as if one after the other.

    They run towards the epipole when the eye has moved forward, and away from it when it has moved
    back.
    """

    name = "forward_ordered"
    summary = (
        "moves each pixel by its own depth, in the occlusion-compatible order from the epipole: no depth comparison"
    )
    exact_when = "as 'forward', of surfaces whose pixels meet along epipolar lines"
    gets_wrong = (
        "the order holds for rays, not pixels: neighbouring lines meet in one pixel and may be swapped at edges; "
        "else as 'forward'"
    )
    source = (
        "McMillan 1995 (UNC TR95-005), Walia and Verma; Mark and Bishop 1997 (why it does not always hold for pixels)"
    )
    Settings = ForwardOrderedSettings

    def defines(self) -> dict[str, object]:
        return {"RINGS": 1} if self.settings.sheets == "rings" else {}

    def order(self, inputs: PassInputs) -> dict[str, object]:
        backward = view_map(inputs.shown, self.shown_size, inputs.rendered.view, self.rendered_size)
        pixel, sense = epipole_pixel(backward.e, self.rendered_size)
        # The origin of the ranks: the greatest distance, or minus the least if running away.
        to_low, to_high = -pixel, np.array(self.rendered_size) - 1 - pixel
        greatest = np.maximum(np.abs(to_low), np.abs(to_high))
        least = np.where((to_low <= 0) & (to_high >= 0), 0, np.minimum(np.abs(to_low), np.abs(to_high)))
        if self.settings.sheets == "rings":
            greatest, least = np.full(2, greatest.max()), np.full(2, least.max())
        start = tuple((greatest if sense > 0 else -least).tolist())
        return {
            "epipole": tuple(pixel),
            "sense": sense,
            "start": start,
        }


def epipole_pixel(e: NDArray[np.float64], size: tuple[int, int]) -> tuple[NDArray[np.int64], int]:
    """Return the rendered pixel (x, y) that holds the shown eye, and 1 or -1.

    1: the shown eye lies ahead of the rendered one (run towards it); -1: behind.
    e: the shown eye in homogeneous pixels, view_map(shown, rendered).e. An epipole at
    infinity or beyond FARTHEST pixels is put that far away in its direction. Without a baseline any
    order is right, and the picture's middle is used.
    """
    middle = np.array(size) / 2
    sense = -1 if e[2] < 0 else 1
    offset = sense * (e[:2] - middle * e[2])  # times 1 / |e.z|, which may be 0
    length, depth = np.hypot(*offset), abs(e[2])
    if length > FARTHEST * depth:
        offset = offset / length * FARTHEST
    elif depth > 0:
        offset = offset / depth
    # An epipole on the border between two pixels counts to the upper one, despite rounding.
    return np.floor(middle + offset + 1e-6).astype(np.int64), sense
