"""The picture, made coarser away from where the eye looks."""

from __future__ import annotations

from typing import Any

from ....frames import EyeImage
from ....frames.layers.foveated import FoveatedPicture
from ....geometry import Fovea
from ....gpu.textures import COLOUR, SCALAR
from . import Drawing, Part, parts

_KINDS = {"foveated": COLOUR, "foveated_depth": SCALAR}


@parts.register
class Foveated(Part):
    """Made when the picture is complete, of colour and of inverse depth where each is needed."""

    name = "foveated"
    order = 195

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        needs = [drawing.needs[name] for name in _KINDS if name in drawing.needs]
        fovea: Fovea = needs[0]
        grid = fovea.grid(eye.view, eye.size)
        made: dict[str, Any] = {}
        for number, (name, kind) in enumerate(_KINDS.items()):
            if name in drawing.needs:
                into = self.context.acquire(grid.small, kind, depth=False).colour
                (eye.inverse_depth if number else eye.colour).bind_to_image(0, read=True, write=False)
                into.bind_to_image(1, read=False, write=True)
                program = self.context.gpu.shaders.compute("server/foveate.comp", DEPTH=number)
                program.uniforms.set(picture=0, foveated=1, **grid.uniforms)
                program.run(*grid.small)
                made[name] = FoveatedPicture(into, grid)
        self.context.gpu.barrier()
        return eye.having(**made)
