"""Mirrors: plane, uneven and curved ones, and what pictures alone tell of them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import attrs
import moderngl
import numpy as np

from ...errors import PlanError
from ...frames import EyeImage, Mirrored, Needs, Others
from ...geometry import View, view_map
from ...geometry.view import mirrors_in_eye, tangents_of_pixels
from ...gpu.context import Gpu
from ...gpu.shaders import Compute
from ...gpu.textures import COLOUR, SCALAR, Canvas, allocate, release_all, tiles
from ..inputs import PassInputs, ShownPicture, as_image
from ..warp_kinds import DEPTH_FLOOR, DEPTH_TOLERANCE
from ..warps import Output
from ..warps.iterative import OF_A_PART, Iterative
from . import Effect, RenderedPass, ShownPass, effects


class Closing:
    """Pull-push through a pyramid for pictures of one size; owns the levels."""

    def __init__(self, gpu: Gpu, size: tuple[int, int]) -> None:
        self._gpu = gpu
        self._down, self._up = (gpu.shaders.compute("effects/reflect_close.comp", PASS=k) for k in range(2))
        sizes = [size]
        while max(sizes[-1]) > 1:
            sizes.append(tiles(sizes[-1], 2))
        self._levels = [allocate(gpu.gl, each, COLOUR, linear=True) for each in sizes[1:]]

    def run(self, picture: moderngl.Texture) -> None:
        """Close the holes of an rgba16f picture with coverage in alpha, in place.

        A picture without covered pixels stays empty.
        """
        levels = [picture, *self._levels]
        for finer, level in zip(levels[:-1], levels[1:], strict=True):
            finer.bind_to_image(0, read=True, write=False)
            level.bind_to_image(1, read=False, write=True)
            self._down.uniforms.set(finer=0, level=1, level_size=level.size)
            self._down.run(*level.size)
            self._gpu.barrier()
        for level, coarser in reversed(list(zip(levels[:-1], levels[1:], strict=True))):
            level.bind_to_image(0, read=True, write=True)
            coarser.use(0)
            pixel = (0.5 / coarser.size[0], 0.5 / coarser.size[1])
            self._up.uniforms.set(level=0, coarser=0, coarser_pixel=pixel, level_size=level.size)
            self._up.run(*level.size)
            self._gpu.barrier()

    def close(self) -> None:
        """Free the levels."""
        release_all(*self._levels)


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

    The other pictures see the same surfaces from elsewhere. What differs is what they mirror. The
    depth of the mirror image, for each block of pixels, is the one at which the differing edges
    agree; then the light is separated by following its rays through the pictures, and the rendered
    picture gets the light that the shown eye sees at each surface. So any warp may follow. A block
    stays as it is where both layers together do not explain the other pictures much better than the
    surfaces alone.
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
        self.chosen, self._unexplained = (allocate(gl, self._blocks, PAIR) for _ in range(2))
        self.image_depth = allocate(gl, self._blocks, PAIR, linear=True)
        self.light, self._next = (allocate(gl, size, COLOUR, linear=True) for _ in range(2))
        self.places = gl.texture_array((*size, PICTURES), 2, dtype="f4")
        self.trust = allocate(gl, self._blocks, SCALAR, linear=True)
        self._joined = allocate(gl, size, COLOUR, linear=True)

    def _shader(self, name: str, **defines: object) -> Compute:
        one_surface = {"SURFACE_TOLERANCE": DEPTH_TOLERANCE, "SURFACE_FLOOR": DEPTH_FLOOR}
        return self.gpu.shaders.compute(f"effects/mirrored_{name}.comp", **one_surface, **defines)

    def _array(self, size: tuple[int, int], layers: int, components: int) -> moderngl.TextureArray:
        array = self.gpu.gl.texture_array((*size, layers), components, dtype="f2")
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
        rendered.inverse_depth.bind_to_image(_DEPTH, read=True, write=False)
        self.aligned.bind_to_image(_OUT, read=False, write=True)
        rendered.colour.bind_to_image(_IN, read=True, write=False)
        self._run(self._own, self.rendered_size, layer=0)
        for layer, other in enumerate(others, start=1):
            warp = view_map(rendered.view, self.rendered_size, other.view, other.size)
            other.colour.filter = (moderngl.LINEAR, moderngl.LINEAR)
            other.colour.use(_OTHER)
            other.inverse_depth.bind_to_image(_OTHER_DEPTH, read=True, write=False)
            sizes = {"other_size": other.size, "other_pixel": (1 / other.size[0], 1 / other.size[1])}
            self._run(self._align, self.rendered_size, layer=layer, H=warp.H, e=warp.e, **sizes)
        self.aligned.use(_ALIGNED)
        across, down = self._blocks
        planes = (across, down * (PLANES + 1))
        self.edges.bind_to_image(_OUT, read=False, write=True)
        self._run(self._edges, self._half, pictures=pictures)
        self.edges.use(_EDGES)
        self.costs.bind_to_image(_OUT, read=False, write=True)
        self._run(self._sweep, planes, pictures=pictures, eyes=eyes)
        for program, size, read, written in (
            (self._rows, planes, self.costs, self._row_sums),
            (self._choose, self._blocks, self._row_sums, self.chosen),
            (self._spread, self._blocks, self.chosen, self.image_depth),
        ):
            read.bind_to_image(_IN, read=True, write=False)
            written.bind_to_image(_OUT, read=False, write=True)
            self._run(program, size)
        self.image_depth.use(_DEPTH_OF_IMAGES)
        self.places.bind_to_image(_OUT, read=False, write=True)
        self._run(self._places, self.rendered_size, pictures=pictures, eyes=eyes)
        self.light.bind_to_image(_OUT, read=False, write=True)
        self._run(self._start, self.rendered_size)
        self.places.bind_to_image(_IN, read=True, write=False)
        for _ in range(ROUNDS):
            self.light.use(_LIGHT)
            self._next.bind_to_image(_OUT, read=False, write=True)
            self._run(self._light, self.rendered_size, pictures=pictures)
            self.light, self._next = self._next, self.light
        self.light.use(_LIGHT)
        self._unexplained.bind_to_image(_OUT, read=False, write=True)
        self._run(self._explain, self._blocks, pictures=pictures)
        self._unexplained.bind_to_image(_IN, read=True, write=False)
        self.trust.bind_to_image(_OUT, read=False, write=True)
        self._run(self._compare, self._blocks)
        rendered.colour.bind_to_image(_IN, read=True, write=False)
        self._joined.bind_to_image(_OUT, read=False, write=True)
        self.trust.use(_TRUST)
        self._run(self._join, self.rendered_size, shown_eye=_seen_from(rendered, shown))
        return attrs.evolve(inputs, rendered=attrs.evolve(rendered, colour=self._joined))

    def _run(self, program: Compute, size: tuple[int, int], **uniforms: Any) -> None:
        wide, high = self.rendered_size
        sizes = {"rendered_size": (wide, high), "rendered_pixel": (1 / wide, 1 / high), "half_size": self._half}
        across, down = self._blocks
        sizes |= {"edges_pixel": (0.5 / self._half[0], 0.5 / self._half[1]), "blocks": self._blocks}
        sizes |= {"image_depth_pixel": (1 / (BLOCK * across), 1 / (BLOCK * down))}
        program.uniforms.set_declared(**_UNITS, **sizes, **uniforms)
        program.run(*size)
        self.gpu.barrier()

    def close(self) -> None:
        release_all(self.aligned, self.edges, self.costs, self._row_sums, self.chosen, self._unexplained)
        release_all(self.image_depth, self.places, self.light, self._next, self.trust, self._joined)


def _seen_from(rendered: EyeImage, eye: View) -> np.ndarray:
    """Return where the rendered view sees another eye: homogeneous pixels, z its depth."""
    return view_map(eye, rendered.size, rendered.view, rendered.size).e


def _has_moved(rendered: EyeImage, eye: View) -> bool:
    """Return whether an eye is elsewhere than the rendered view's: else nothing can differ."""
    return bool(np.abs(_seen_from(rendered, eye)).max() > STILL)


effects.register(
    Effect(
        name="planar_reflections",
        order=10,
        summary="what plane mirrors show is a layer with the depth of the whole path, and is warped as the world "
        "behind the mirror",
        applies=lambda _, mesh: mesh.material.reflectivity > 0 and not mesh.material.curved,
        made_by=Reflections,
        needs=Needs(reflection=Mirrored.PLANE),
        without="reflections stick to the mirrors, as if painted on them",
        source="Akenine-Moeller et al. 2018, Real-Time Rendering, 11.6.2 (mirrored geometry); Lochmann et al. 2014, "
        "Real-time Reflective "
        "and Refractive Novel-view Synthesis (warping by the length of the path)",
    )
)

effects.register(
    Effect(
        name="glossy_reflections",
        order=11,
        summary="the normal map disturbs where the warped reflection is sampled, for the head pose now",
        applies=lambda _, mesh: mesh.material.normal_map >= 0,
        made_by=Reflections,
        needs=Needs(reflection=Mirrored.PLANE),
        without="uneven mirrors show an even reflection",
        source="the 2014 thesis's order of steps (warp the even reflection, then disturb it)",
        refines="planar_reflections",
    )
)

effects.register(
    Effect(
        name="curved_reflections",
        order=12,
        summary="what a curved mirror shows is warped at the depth of its image by the mirror formula: half the "
        "radius for far things",
        applies=lambda _, mesh: mesh.material.curved,
        made_by=Reflections,
        needs=Needs(reflection=Mirrored.CURVED),
        without="reflections stick to the ball, as if painted on it",
        source="Coddington 1829 (oblique pencils), see hmdwarp/geometry/view.py; Lochmann et al. 2014",
    )
)

effects.register(
    Effect(
        name="reflections_from_pictures",
        order=15,
        summary="the other eye's picture and two older ones tell what mirrors show, and how far behind them; "
        "no data on mirrors are needed",
        applies=lambda scene, mesh: True,
        by_name_only=True,
        instead_of=("planar_reflections", "glossy_reflections", "curved_reflections"),
        made_by=MirroredPass,
        needs=Needs(others=Others(past=2, spacing_ns=300_000_000, other_eye=True)),
        without="reflections stick to the mirrors, as if painted on them",
        source="Sinha et al. 2012, Image-Based Rendering for Scenes with Reflections; Weiss 2001, Deriving Intrinsic "
        "Images from Image Sequences; Szeliski et al. 2000, Layer Extraction from Multiple Images Containing "
        "Reflections and Transparency",
    )
)
