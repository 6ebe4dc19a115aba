"""The second, wide and coarse view of an eye: a whole picture of its own, with depth."""

from __future__ import annotations

import attrs

from ....frames import EyeImage, Needs
from ....geometry.cube import wide_size, wide_view
from . import Drawing, Part, parts


@parts.register
class Wide(Part):
    """As wide as geometry.wide says, around the view without guard band.

    Everything is drawn into it, without layers, except for head-locked content.
    """

    name = "wide"
    order = 120

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        view, size = wide_view(drawing.view), wide_size(drawing.view.fov, drawing.size)
        wide = drawing.of_light(view, size)
        wide = attrs.evolve(wide, needs=wide.needs | Needs(overlay=drawing.needs.get("overlay")))
        return eye.having(wide=self.context.draw(view, size, wide))
