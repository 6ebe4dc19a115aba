"""One pass for all mirrors: warp the mirrored world and draw it into the warped surfaces."""

from __future__ import annotations

from collections.abc import Iterator

import attrs
import moderngl

from ...errors import PlanError
from ...frames import EyeImage
from ...geometry.view import mirrors_in_eye, tangents_of_pixels
from ...gpu.textures import COLOUR, SCALAR, Canvas, allocate, release_all
from ..carry import as_image
from ..effects import ShownPass
from ..inputs import PassInputs, ShownPicture
from ..warps import Output
from ..warps.iterative import OF_A_PART, Iterative
from .closing import Closing

GLOSSY = "glossy_reflections"


class Reflections(ShownPass):
    """Warp the mirrored world by its own depth, and the mirrors' surfaces along with the colour.

    The mirrored world is gathered (`iterative`), and its holes are closed from around them. Under
    scan-out it is shown as in the middle of it. Where a fill has closed holes of the picture, they
    reflect as much as their surroundings.
    """

    name = "reflections"
    reads = ("shown.colour", "rendered.reflection")
    carries = True

    def prepare(self) -> None:
        gpu, shown = self.gpu, self.shown_size
        glossy = GLOSSY in self.parts
        self._compose = gpu.shaders.compute("effects/reflect.comp", grid="shown", **({"GLOSSY": 1} if glossy else {}))
        self._nothing = gpu.shaders.compute("effects/reflect_none.comp")
        with gpu.shaders.hidden.skipping(False):  # holes are closed from all around them
            self._warp = Iterative(gpu, self.rendered_size, shown, OF_A_PART, Output(depth=glossy))
        self._seen_depth = allocate(gpu.gl, shown, SCALAR) if glossy else None
        self._closing = Closing(gpu, shown)
        self._seen, self._surface = Canvas(gpu.gl, shown), Canvas(gpu.gl, shown)
        self._plain = [allocate(gpu.gl, self.rendered_size, COLOUR) for _ in range(self.tools.pictures - 1)]

    def run(self, inputs: PassInputs, picture: ShownPicture, into: Canvas) -> None:
        reflection = inputs.rendered.get("reflection")
        if reflection is None:
            raise PlanError(
                "reflections are compensated, but this frame has no layer of them; frames from a scene have it"
            )
        seen = attrs.evolve(inputs.at_once(), rendered=as_image(inputs.rendered, reflection.seen), others=())
        if self._seen_depth is None:
            self._warp.run(seen, self._seen)
        else:
            self._warp.run_with_depth(seen, self._seen, self._seen_depth)
        self.gpu.barrier()
        self._closing.run(self._seen.texture)
        free = iter(self._plain)
        self.tools.carry.along(inputs, lambda image: self._surface_of(image, free), self._surface)
        self.gpu.barrier()
        self._closing.run(self._surface.texture)
        self._draw(inputs, picture, into)

    def _surface_of(self, image: EyeImage, free: Iterator[moderngl.Texture]) -> moderngl.Texture:
        if "reflection" in image:
            surface: moderngl.Texture = image["reflection"].surface
            return surface
        into = next(free)
        image.colour.bind_to_image(0, read=True, write=False)
        into.bind_to_image(1, read=False, write=True)
        self._nothing.uniforms.set(rendered_colour=0, surface=1, rendered_size=image.size)
        self._nothing.run(*image.size)
        self.gpu.barrier()
        return into

    def _draw(self, inputs: PassInputs, picture: ShownPicture, into: Canvas) -> None:
        read = {"picture": picture.colour.texture, "surface": self._surface.texture}
        if self._seen_depth is not None:
            read["seen_inverse_depth"] = self._seen_depth
        for unit, texture in enumerate(read.values(), start=1):
            texture.bind_to_image(unit, read=True, write=False)
        into.bind_for_writing(0)
        self._seen.texture.use(0)
        units = {name: unit for unit, name in enumerate(read, start=1)}
        mirrors = mirrors_in_eye(inputs.rendered["reflection"].mirrors, inputs.middle) | tangents_of_pixels(
            inputs.middle, self.shown_size
        )
        pixel = (1 / self.shown_size[0], 1 / self.shown_size[1])
        self._compose.uniforms.set(seen=0, seen_pixel=pixel, written=0, shown_size=self.shown_size, **units, **mirrors)
        self._compose.run(*self.shown_size)

    def close(self) -> None:
        for owner in (self._warp, self._closing):
            owner.close()
        if self._seen_depth is not None:
            self._seen_depth.release()
        release_all(self._seen, self._surface, *self._plain)
