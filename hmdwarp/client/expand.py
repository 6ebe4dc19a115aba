"""Bring a foveated picture back to the pixels of the rendered one, for all passes after it."""

from __future__ import annotations

from typing import Any

import attrs

from ..frames import EyeImage
from ..frames.layers import readable
from ..gpu.textures import COLOUR, SCALAR, allocate, release_all
from .effects import RenderedPass
from .inputs import PassInputs

# By the layer: the picture that it stands for, and its kind of texture.
_PICTURES = {"foveated": ("colour", COLOUR), "foveated_depth": ("inverse_depth", SCALAR)}
EXPANDED = {layer: readable(picture) for layer, (picture, _) in _PICTURES.items()}


class ExpandPass(RenderedPass):
    """Expand each rendered picture that came foveated; parts: the layers that it comes in.

    Warps, fills and effects read the result as if it had come whole, so that each works as it is.
    """

    name = "expand"
    needs_compute = False
    reads = ("rendered.foveated", "rendered.foveated_depth")

    def prepare(self) -> None:
        self._programs, self._pictures = {}, {}
        for number, (layer, (_, kind)) in enumerate(_PICTURES.items()):
            if layer in self.parts:
                self._programs[layer] = self.gpu.shaders.compute("effects/expand.comp", DEPTH=number)
                self._pictures[layer] = [
                    allocate(self.gpu.gl, self.rendered_size, kind) for _ in range(self.tools.images)
                ]

    def run(self, inputs: PassInputs) -> PassInputs:
        return inputs.having(self._expanded(image, number) for number, image in enumerate(inputs.images))

    def _expanded(self, image: EyeImage, number: int) -> EyeImage:
        """Return the image with its whole picture; the same object where it came whole."""
        found = {layer: image[layer] for layer in self._programs if layer in image}
        if not found:
            return image
        pictures: dict[str, Any] = {}
        for layer, picture in found.items():
            program, into = self._programs[layer], self._pictures[layer][number]
            picture.texture.bind_to_image(0, read=True, write=False)
            into.bind_to_image(1, read=False, write=True)
            program.uniforms.set(foveated=0, picture=1, **picture.grid.uniforms)
            program.run(*picture.grid.small)
            pictures[_PICTURES[layer][0]] = into
        self.gpu.barrier()
        came = {EXPANDED[layer] for layer in found}
        return attrs.evolve(image, **pictures, left_out=image.left_out - came)

    def close(self) -> None:
        release_all(*(texture for several in self._pictures.values() for texture in several))
