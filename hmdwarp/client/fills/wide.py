"""A second, wide and coarse view from the rendered eye extends the picture beyond its border."""

from __future__ import annotations

from typing import Any

from ...frames import Needs
from ...geometry.cube import COARSER
from ..fill_parts import HoleFiller
from ..inputs import PassInputs, ShownPicture
from ..warp_kinds import DepthPicture
from . import fills
from ._base import Fill


@fills.register
class Wide(Fill):
    """Gather from the wide view where the warp left holes.

    They lie mostly at the border, and at edges where the wide view saw more.
    """

    name = "wide"
    summary = "a second view of 150 x 140 degrees at a quarter of the resolution, drawn and sent with every frame"
    reads = ("shown.colour", "rendered.wide")
    writes = ("shown.colour", "shown.inverse_depth")
    source = "this project's; the gather of Bowles et al. 2012"

    def prepare(self) -> None:
        self._holes = HoleFiller(self.gpu, self.shown_size, COARSER)

    def run(self, inputs: PassInputs, picture: ShownPicture, into: ShownPicture) -> None:
        wide = inputs.rendered["wide"]
        self._holes.start(picture, into)
        self._holes.add(DepthPicture(wide.colour, wide.inverse_depth, wide.view), inputs.middle)

    def close(self) -> None:
        self._holes.close()

    @classmethod
    def needs(cls, settings: Any) -> Needs:
        return Needs(wide=True)
