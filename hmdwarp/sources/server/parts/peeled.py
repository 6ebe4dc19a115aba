"""Occluded surfaces, one layer after the other: depth peeling.

Source: Everitt 2001, Interactive Order-Independent Transparency. Each pass draws the scene again
without everything that is not behind the previous layer. Every surface that faces the eye counts,
also one close behind another (a picture on a wall): without it, the surface behind both would
wrongly take its place.
"""

from __future__ import annotations

from ....frames import EyeImage, Surface
from ..passes import SAME_SURFACE, ScenePasses
from ..upload import Moving
from . import DrawContext, Drawing, Part, parts


@parts.register
class Peeled(Part):
    """Surfaces behind the picture's own, nearest first.

    Moving things are left out, since the client moves them: the surface behind then fills the place
    that they leave.
    """

    name = "peeled"
    order = 100

    def __init__(self, context: DrawContext) -> None:
        super().__init__(context)
        self._passes: dict[tuple[ScenePasses, tuple[Moving, ...]], ScenePasses] = {}

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        plain = self.context.passes_for(drawing)
        moving = tuple(mover for mover in plain.moving if mover.layer not in drawing.needs)
        if (plain, moving) not in self._passes:
            self._passes[plain, moving] = plain.peeling(moving)
        passes = self._passes[plain, moving]
        before, surfaces = eye.inverse_depth, []
        for _ in range(drawing.needs["peeled"]):
            target = self.context.acquire(eye.size)
            before.use(1)
            into = self.context.framebuffers.over(target.colour, target.inverse_depth)
            passes.draw(eye.view, into, eye.drawn_ns, in_front=1, keep=1 - SAME_SURFACE)
            surfaces.append(Surface(target.colour, target.inverse_depth))
            before = target.inverse_depth
        return eye.having(peeled=tuple(surfaces))

    def close(self) -> None:
        for passes in self._passes.values():
            passes.close()
