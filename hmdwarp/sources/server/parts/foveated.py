"""The picture, made coarser away from where the eye looks, or drawn so."""

from __future__ import annotations

from typing import Any

import attrs
import moderngl

from ....frames import EyeImage
from ....frames.layers.foveated import FoveatedPicture
from ....geometry import Fovea, InsetGrid
from ....gpu.textures import COLOUR, SCALAR
from . import Drawing, Part, parts

_KINDS = {"foveated": COLOUR, "foveated_depth": SCALAR}


@parts.register
class Foveated(Part):
    """Made when the picture is complete, of colour and of inverse depth where each is needed.

    With an inset two pictures are drawn, and the eye's own one is not read.
    """

    name = "foveated"
    order = 195

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        needs = [drawing.needs[name] for name in _KINDS if name in drawing.needs]
        fovea: Fovea = needs[0]
        grid = fovea.grid(eye.view, eye.size)
        pictures = [eye]
        if isinstance(grid, InsetGrid):
            (coarse, inset), (x, y) = grid.views(eye.view), grid.at
            # With the whole picture's projection: a polygon that is cut at another border has other
            # edges, where several samples have other middles.
            whole = (attrs.evolve(eye.view, hidden=None), (-x, -y, *grid.size))
            sharp = attrs.evolve(drawing.of_light(inset, grid.inset), part_of=whole)
            pictures = [
                self.context.draw(coarse, grid.coarse, drawing.of_light(coarse, grid.coarse)),
                self.context.draw(inset, grid.inset, sharp),
            ]
        made: dict[str, Any] = {}
        for number, (name, kind) in enumerate(_KINDS.items()):
            if name in drawing.needs:
                into = self.context.acquire(grid.small, kind, depth=False).colour
                self._write([one.inverse_depth if number else one.colour for one in pictures], into, number, grid)
                made[name] = FoveatedPicture(into, grid)
        self.context.gpu.barrier()
        for one in pictures[1:] and pictures:
            self.context.give_back(one)
        return eye.having(**made)

    def _write(self, pictures: list[moderngl.Texture], into: moderngl.Texture, number: int, grid: Any) -> None:
        """Write colour (0) or inverse depth (1): of a picture, or of a coarse one and an inset."""
        is_inset = len(pictures) > 1
        program = self.context.gpu.shaders.compute("server/foveate.comp", DEPTH=number, INSET=int(is_inset))
        pictures[0].bind_to_image(0, read=True, write=False)
        into.bind_to_image(1, read=False, write=True)
        if is_inset:
            pictures[1].bind_to_image(2, read=True, write=False)
            program.uniforms.set(inset=2)
        program.uniforms.set(picture=0, foveated=1, **grid.uniforms)
        program.run(*grid.small)
