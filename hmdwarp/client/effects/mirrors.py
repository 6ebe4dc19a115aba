"""Mirrors: plane, uneven and curved ones, and what pictures alone tell of them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import attrs
import moderngl
import numpy as np

from ...base import PlanError
from ...frames import EyeImage, Mirrored, Needs, Others
from ...geometry import View, view_map
from ...geometry.view import mirrors_in_eye, tangents_of_pixels
from ...gpu import Compute, Gpu
from ...gpu.textures import COLOUR, SCALAR, Canvas, Owner, allocate, bind_images, tiles
from ..inputs import PassInputs, ShownPicture, as_image
from ..warps import Output, pixel_of
from ..warps.gather import DEPTH_FLOOR, DEPTH_TOLERANCE, bind_rendered_colour
from ..warps.iterative import OF_A_PART, Iterative
from . import RenderedPass, ShownPass, effects


class Closing(Owner):
    """Pull-push through a pyramid for pictures of one size; owns the levels."""

    def __init__(self, gpu: Gpu, size: tuple[int, int]) -> None:
        self._gpu = gpu
        self._down, self._up = (gpu.shaders.compute("effects/reflect_close.comp", PASS=k) for k in range(2))
        sizes = [size]
        while max(sizes[-1]) > 1:
            sizes.append(tiles(sizes[-1], 2))
        self._levels = [self.own(allocate(gpu.gl, each, COLOUR, linear=True)) for each in sizes[1:]]

    def run(self, picture: moderngl.Texture) -> None:
        """Close the holes of an rgba16f picture with coverage in alpha, in place.

        A picture without covered pixels stays empty.
        """
        levels = [picture, *self._levels]
        for finer, level in zip(levels[:-1], levels[1:], strict=True):
            self._down.uniforms.set(level_size=level.size, **bind_images({"finer": finer}, {"level": level}))
            self._down.run(*level.size)
            self._gpu.barrier()
        for level, coarser in reversed(list(zip(levels[:-1], levels[1:], strict=True))):
            coarser.use(0)
            pixel = (0.5 / coarser.size[0], 0.5 / coarser.size[1])
            units = bind_images(change={"level": level})
            self._up.uniforms.set(coarser=0, coarser_pixel=pixel, level_size=level.size, **units)
            self._up.run(*level.size)
            self._gpu.barrier()


GLOSSY = "glossy_reflections"


class Reflections(ShownPass):
    """Warp the mirrored world by its own depth, and the mirrors' surfaces along with the colour.

    The mirrored world is gathered (`iterative`), under scan-out as in its middle, and its holes are
    closed from around them. Where a fill has closed holes, they reflect as their surroundings.
    """

    name = "reflections"
    reads = ("shown.colour", "rendered.reflection")
    carries = True

    def prepare(self) -> None:
        gpu, shown, gl = self.gpu, self.shown_size, self.gpu.gl
        glossy = GLOSSY in self.parts
        self._compose = gpu.shaders.compute("effects/reflect.comp", grid="shown", **({"GLOSSY": 1} if glossy else {}))
        self._nothing = gpu.shaders.compute("effects/reflect_none.comp")
        with gpu.shaders.hidden.skipping(False):  # holes are closed from all around them
            self._warp = self.own(Iterative(gpu, self.rendered_size, shown, OF_A_PART, Output(depth=glossy)))
        self._seen_depth = self.own(allocate(gl, shown, SCALAR)) if glossy else None
        self._closing = self.own(Closing(gpu, shown))
        self._seen, self._surface = self.own(Canvas(gl, shown)), self.own(Canvas(gl, shown))
        plain = (allocate(gl, self.rendered_size, COLOUR) for _ in range(self.tools.pictures - 1))
        self._plain = [self.own(texture) for texture in plain]

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
        read = {"picture": picture.colour.texture, "surface": self._surface.texture}
        if self._seen_depth is not None:
            read["seen_inverse_depth"] = self._seen_depth
        self._seen.texture.use(0)
        mirrors, size = mirrors_in_eye(reflection.mirrors, inputs.middle), self.shown_size
        named = bind_images(read, {"written": into}) | mirrors | tangents_of_pixels(inputs.middle, size)
        self._compose.uniforms.set(seen=0, seen_pixel=pixel_of(size), shown_size=size, **named)
        self._compose.run(*size)

    def _surface_of(self, image: EyeImage, free: Iterator[moderngl.Texture]) -> moderngl.Texture:
        if "reflection" in image:
            surface: moderngl.Texture = image["reflection"].surface
            return surface
        into = next(free)
        units = bind_images({"rendered_colour": image.colour}, {"surface": into})
        self._nothing.uniforms.set(rendered_size=image.size, **units)
        self._nothing.run(*image.size)
        self.gpu.barrier()
        return into


PICTURES = 4  # the rendered one and three more: as many as the shaders' vectors hold
PLANES = 16  # depths that are tried behind a surface, equally far apart in inverse depth
ROUNDS = 6  # that separate the light in mirrors from that of the surfaces
BLOCK = 8  # as in shaders/effects/mirrored.glsl
PAIR = (2, "f4")
STILL = 1e-6  # of the place of an eye, in pixels times metres: rounding of equal poses
# Texture units of what is sampled, and image units of what is read or written pixel by pixel.
_ALIGNED, _EDGES, _LIGHT, _DEPTH_OF_IMAGES, _TRUST, _OTHER = range(6)
# moderngl sets no units of arrays: the shaders state those of _IN and _OUT themselves.
_DEPTH, _IN, _OUT, _OTHER_DEPTH = range(4)
_UNITS = {
    **{"aligned": _ALIGNED, "edges": _EDGES, "light_before": _LIGHT, "image_depth": _DEPTH_OF_IMAGES, "trust": _TRUST},
    **{"other_colour": _OTHER, "rendered_inverse_depth": _DEPTH, "given": _IN, "written": _OUT},
    "other_inverse_depth": _OTHER_DEPTH,
}


class MirroredPass(RenderedPass):
    """Splits the rendered picture into the surfaces' own light and what they mirror.

    What differs in other pictures of the same surfaces is what they mirror. The depth of the mirror
    image, for each block of pixels, is the one at which the differing edges agree; then the light
    is separated by following its rays through the pictures, and the rendered picture gets the light
    that the shown eye sees at each surface. So any warp may follow. A block stays as it is where
    both layers together do not explain the other pictures much better than the surfaces alone.
    """

    name = "mirrored light"
    reads = ("rendered.colour", "rendered.inverse_depth", "rendered.others")
    writes = ("rendered.colour",)

    def prepare(self) -> None:
        gl, size = self.gpu.gl, self.rendered_size
        self._half, self._blocks = tiles(size, 2), tiles(size, BLOCK)
        names = ("align", "edges", "spread", "places", "light", "join")
        self._align, self._edges, self._spread, self._places, self._light, self._join = (
            self._shader(name) for name in names
        )
        self._own = self._shader("align", OWN=1)
        self._start = self._shader("light", START=1)
        self._sweep = self._shader("sweep", PLANES=PLANES)
        self._rows, self._choose = (self._shader("choose", PASS=k, PLANES=PLANES) for k in range(2))
        self._explain, self._compare = (self._shader("trust", PASS=k) for k in range(2))
        self.aligned, self.edges = self._array(size, PICTURES, 4), self._array(self._half, PICTURES, 4)
        self.costs, self._row_sums = (self._array(self._blocks, PLANES + 1, components) for components in (2, 4))
        self.chosen, self._unexplained = (self.own(allocate(gl, self._blocks, PAIR)) for _ in range(2))
        self.image_depth, self.trust = (self.own(allocate(gl, self._blocks, k, linear=True)) for k in (PAIR, SCALAR))
        self.light, self._next, self._joined = (self.own(allocate(gl, size, COLOUR, linear=True)) for _ in range(3))
        self.places = self.own(gl.texture_array((*size, PICTURES), 2, dtype="f4"))

    def _shader(self, name: str, **defines: object) -> Compute:
        one_surface = {"SURFACE_TOLERANCE": DEPTH_TOLERANCE, "SURFACE_FLOOR": DEPTH_FLOOR}
        return self.gpu.shaders.compute(f"effects/mirrored_{name}.comp", **one_surface, **defines)

    def _array(self, size: tuple[int, int], layers: int, components: int) -> moderngl.TextureArray:
        array = self.own(self.gpu.gl.texture_array((*size, layers), components, dtype="f2"))
        array.repeat_x = array.repeat_y = False
        array.filter = (moderngl.LINEAR, moderngl.LINEAR)
        return array

    def run(self, inputs: PassInputs) -> PassInputs:
        rendered, shown = inputs.rendered, inputs.middle
        others = [image for image in inputs.others if _has_moved(rendered, image.view)][: PICTURES - 1]
        if not others or not _has_moved(rendered, shown):
            return inputs
        eyes, pictures = np.zeros((PICTURES, 3)), 1 + len(others)
        eyes[1:pictures] = [_seen_from(rendered, image.view) for image in others]
        seen = {"pictures": pictures, "eyes": eyes}
        rendered.inverse_depth.bind_to_image(_DEPTH, read=True, write=False)
        self._run(self._own, self.rendered_size, rendered.colour, self.aligned, layer=0)
        for layer, other in enumerate(others, start=1):
            warp = view_map(rendered.view, self.rendered_size, other.view, other.size)
            bind_rendered_colour(other, _OTHER, whole_pixels=False)
            other.inverse_depth.bind_to_image(_OTHER_DEPTH, read=True, write=False)
            there = {"H": warp.H, "e": warp.e, "other_size": other.size, "other_pixel": pixel_of(other.size)}
            self._run(self._align, self.rendered_size, None, self.aligned, layer=layer, **there)
        self.aligned.use(_ALIGNED)
        across, down = self._blocks
        planes = (across, down * (PLANES + 1))
        self._run(self._edges, self._half, None, self.edges, pictures=pictures)
        self.edges.use(_EDGES)
        self._run(self._sweep, planes, None, self.costs, **seen)
        self._run(self._rows, planes, self.costs, self._row_sums)
        self._run(self._choose, self._blocks, self._row_sums, self.chosen)
        self._run(self._spread, self._blocks, self.chosen, self.image_depth)
        self.image_depth.use(_DEPTH_OF_IMAGES)
        self._run(self._places, self.rendered_size, None, self.places, **seen)
        self._run(self._start, self.rendered_size, None, self.light)
        for _ in range(ROUNDS):
            self.light.use(_LIGHT)
            self._run(self._light, self.rendered_size, self.places, self._next, pictures=pictures)
            self.light, self._next = self._next, self.light
        self.light.use(_LIGHT)
        self._run(self._explain, self._blocks, self.places, self._unexplained, pictures=pictures)
        self._run(self._compare, self._blocks, self._unexplained, self.trust)
        self.trust.use(_TRUST)
        shown_eye = _seen_from(rendered, shown)
        self._run(self._join, self.rendered_size, rendered.colour, self._joined, shown_eye=shown_eye)
        return attrs.evolve(inputs, rendered=attrs.evolve(rendered, colour=self._joined))

    def _run(self, program: Compute, size: tuple[int, int], read: Any, written: Any, **uniforms: Any) -> None:
        """Run a pass from one texture, or from samplers alone, into another."""
        if read is not None:
            read.bind_to_image(_IN, read=True, write=False)
        written.bind_to_image(_OUT, read=False, write=True)
        sizes = {"rendered_size": self.rendered_size, "rendered_pixel": pixel_of(self.rendered_size)}
        across, down = self._blocks
        sizes |= {"edges_pixel": (0.5 / self._half[0], 0.5 / self._half[1]), "half_size": self._half}
        sizes |= {"image_depth_pixel": (1 / (BLOCK * across), 1 / (BLOCK * down)), "blocks": self._blocks}
        program.uniforms.set_declared(**_UNITS, **sizes, **uniforms)
        program.run(*size)
        self.gpu.barrier()


def _seen_from(rendered: EyeImage, eye: View) -> np.ndarray:
    """Return where the rendered view sees another eye: homogeneous pixels, z its depth."""
    return view_map(eye, rendered.size, rendered.view, rendered.size).e


def _has_moved(rendered: EyeImage, eye: View) -> bool:
    """Return whether an eye is elsewhere than the rendered view's: else nothing can differ."""
    return bool(np.abs(_seen_from(rendered, eye)).max() > STILL)


effects.declare(
    "planar_reflections",
    Reflections,
    Needs(reflection=Mirrored.PLANE),
    applies=lambda _, mesh: mesh.material.reflectivity > 0 and not mesh.material.curved,
)

effects.declare(
    "glossy_reflections",
    Reflections,
    Needs(reflection=Mirrored.PLANE),
    applies=lambda _, mesh: mesh.material.normal_map >= 0,
)

effects.declare(
    "curved_reflections", Reflections, Needs(reflection=Mirrored.CURVED), applies=lambda _, mesh: mesh.material.curved
)

effects.declare(
    "reflections_from_pictures",
    MirroredPass,
    Needs(others=Others(past=2, spacing_ns=300_000_000, other_eye=True)),
    applies=lambda scene, mesh: True,
)
