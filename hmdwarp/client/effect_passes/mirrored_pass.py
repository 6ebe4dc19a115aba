"""Find what mirrors show in pictures alone, and move it to where the eye sees it now."""

from __future__ import annotations

from typing import Any

import attrs
import moderngl
import numpy as np

from ...frames import EyeImage
from ...geometry import View, view_map
from ...gpu.shaders import Compute
from ...gpu.textures import COLOUR, SCALAR, allocate, release_all, tiles
from ..effects import RenderedPass
from ..inputs import PassInputs
from ..warp_kinds import DEPTH_FLOOR, DEPTH_TOLERANCE

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
        eyes = np.zeros((PICTURES, 3))
        eyes[1 : 1 + len(others)] = [_seen_from(rendered, image.view) for image in others]
        rendered.inverse_depth.bind_to_image(_DEPTH, read=True, write=False)
        self._align_pictures(rendered, others)
        self._find_images(1 + len(others), eyes)
        self._separate(1 + len(others), eyes)
        rendered.colour.bind_to_image(_IN, read=True, write=False)
        self._joined.bind_to_image(_OUT, read=False, write=True)
        self.trust.use(_TRUST)
        self._run(self._join, self.rendered_size, shown_eye=_seen_from(rendered, shown))
        return attrs.evolve(inputs, rendered=attrs.evolve(rendered, colour=self._joined))

    def _align_pictures(self, rendered: EyeImage, others: list[EyeImage]) -> None:
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

    def _find_images(self, pictures: int, eyes: np.ndarray) -> None:
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

    def _separate(self, pictures: int, eyes: np.ndarray) -> None:
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
