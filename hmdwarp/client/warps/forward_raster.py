"""Forward warping without a depth test, to show its artefacts."""

from __future__ import annotations

from ..inputs import PassInputs
from ..warp_kinds import OrderedScatter
from . import warps


@warps.register
class ForwardRaster(OrderedScatter):
    """Scatter pixels as if one after the other, in raster order; the last one wins.

    Raster order runs row by row from the top of the picture, each from left to right.
    """

    name = "forward_raster"
    summary = "moves each pixel by its own depth, the last one in raster order wins: shows why a depth test is needed"
    exact_when = "the eye does not move"
    gets_wrong = (
        "shows hidden things through what hides them, wherever they come later in the picture; "
        "cracks and holes as 'forward'"
    )
    source = "what McMillan 1995 (UNC TR95-005) and the 2014 thesis set out from: pixels moved in raster order"

    def order(self, inputs: PassInputs) -> dict[str, object]:
        return {}
