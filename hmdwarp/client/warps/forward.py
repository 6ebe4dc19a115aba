"""Forward warping: each rendered pixel moves by its own depth, as a point or as a footprint."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar, Literal

import attrs
import moderngl
import numpy as np
from numpy.typing import NDArray

from ...base import InputError
from ...geometry import WarpMap, view_map
from ...gpu import Compute, Gpu
from ...gpu.textures import Canvas, bind_images
from ..inputs import PassInputs
from ..settings import chosen, limited
from . import KEY_BYTES, warps
from ._base import Warp
from .gather import depth_limits

LONGEST_SIDE = 2**14  # a rank has 15 bits for a row and 15 for a column, one of each to spare


class ScatterWarp(Warp):
    """A warp in which rendered pixels move by their own depth."""

    kind = "scatter"
    reads = ("rendered.colour", "rendered.inverse_depth")
    depth_reads: ClassVar[tuple[str, ...] | None] = ("rendered.inverse_depth",)

    def forward_map(self, inputs: PassInputs) -> WarpMap:
        """Return the map from rendered to shown pixels."""
        return view_map(inputs.rendered.view, self.rendered_size, inputs.shown, self.shown_size)

    def bind(self, inputs: PassInputs, into: Canvas) -> None:
        """Bind the rendered picture and the result as images for compute shaders."""
        read = {"rendered_colour": inputs.rendered.colour, "rendered_inverse_depth": inputs.rendered.inverse_depth}
        depth = {} if self.depth_into is None else {"shown_inverse_depth": self.depth_into}
        self._units = bind_images(read, {"shown_colour": into, **depth})

    @property
    def depth_defines(self) -> dict[str, object]:
        """Defines of the shader that writes the shown pixels."""
        return {"WRITES_DEPTH": 1} if self.output.depth else {}

    def set(self, program: Compute, **more: object) -> None:
        """Set the sizes, the image units, and those of `more` that the program declares."""
        self.set_sizes(program)
        program.uniforms.set_declared(**self._units, **more)

    def empty_keys(self) -> moderngl.Buffer:
        """Return a key for each shown pixel, all 0: nothing has landed.

        Errors: InputError for a picture beyond the GPU's buffer size.
        """
        check_room(self.gpu, self.name, self.shown_size, KEY_BYTES)
        keys = self.own(self.gpu.gl.buffer(reserve=KEY_BYTES * self.shown_size[0] * self.shown_size[1]))
        keys.clear()
        return keys


class OrderedScatter(ScatterWarp):
    """A scatter in which the last rendered pixel in some order wins.

    The shader `warps/NAME.comp` computes the order: each rendered pixel offers its rank, and the
    largest wins. The pass that copies the colours clears the keys again.
    """

    def prepare(self) -> None:
        if max(self.rendered_size) > LONGEST_SIDE:
            wide, high = self.rendered_size
            raise InputError(
                f"a rendered picture of {wide}x{high}: '{self.name}' takes at most {LONGEST_SIDE} pixels a side"
            )
        path, defines, shaders = f"warps/{self.name}.comp", self.defines(), self.gpu.shaders
        self._scatter = shaders.compute(path, grid="rendered", PASS=0, **defines)
        self._resolve = shaders.compute(path, PASS=1, **defines, **self.depth_defines)
        self._keys = self.empty_keys()

    def defines(self) -> dict[str, object]:
        """Return further defines of the shader."""
        return {}

    @abstractmethod
    def order(self, inputs: PassInputs) -> dict[str, object]:
        """Return the uniforms that define the order."""

    def run(self, inputs: PassInputs, into: Canvas) -> None:
        forward, order = self.forward_map(inputs), self.order(inputs)
        self.bind(inputs, into)
        self._keys.bind_to_storage_buffer(0)
        for program, size in ((self._scatter, self.rendered_size), (self._resolve, self.shown_size)):
            self.gpu.barrier()
            self.set(program, H=forward.H, e=forward.e, **order)
            program.run(*size)


def check_room(gpu: Gpu, name: str, size: tuple[int, int], bytes_per_pixel: int, header: int = 0) -> None:
    """Raise InputError if one shader buffer cannot hold so many bytes per shown pixel."""
    pixels = (gpu.gl.info["GL_MAX_SHADER_STORAGE_BLOCK_SIZE"] - header) // (4 * bytes_per_pixel) * 4
    if size[0] * size[1] > pixels:
        wanted = f"a shown picture of {size[0]}x{size[1]}: '{name}' keeps {bytes_per_pixel} bytes a pixel"
        raise InputError(f"{wanted}, this GPU has room for {pixels} pixels")


MOST_PIXELS = 2**27 - 2  # the keys of infinitely far pixels are indices below 2^27, see shaders/lib/scatter_depth.glsl
_TIE_HEADER = 16  # bytes before the winners: three work-group counts and one spare


@warps.register
class Forward(ScatterWarp):
    """Scatters pixels with an exact depth test: two atomic passes, and three more where keys tie.

    Of equal depths the lower (row mod 4, column mod 4) wins.
    """

    name = "forward"

    def prepare(self) -> None:
        wide, high = self.rendered_size
        if wide * high > MOST_PIXELS:
            raise InputError(f"a rendered picture of {wide}x{high}: 'forward' takes at most {MOST_PIXELS} pixels")
        shaders, gl = self.gpu.shaders, self.gpu.gl
        self._clear = shaders.compute("warps/forward_clear.comp")
        self._nearest, self._colour, *self._settle = (
            shaders.compute("warps/forward.comp", grid="rendered", PASS=k) for k in range(5)
        )
        check_room(self.gpu, self.name, self.shown_size, KEY_BYTES, _TIE_HEADER)
        self._quads = -(-self.shown_size[0] * self.shown_size[1] // 4)
        self._keys = self.own(gl.buffer(reserve=16 * self._quads))
        # Reads the shown depth out of the keys, where it is needed.
        self._depth = shaders.compute("warps/forward_depth.comp", grid="shown") if self.output.depth else None
        self._ties = self.own(gl.buffer(bytes(_TIE_HEADER) + b"\xff" * (16 * self._quads)))

    def run(self, inputs: PassInputs, into: Canvas) -> None:
        self.bind(inputs, into)
        forward = self.forward_map(inputs)
        self._keys.bind_to_storage_buffer(0)
        self._ties.bind_to_storage_buffer(1)
        into.clear()
        groups = self._nearest.groups(*self.rendered_size)
        self._clear.uniforms.set(quads=self._quads, tie_dispatch=groups)
        self._clear.run(self._quads)
        for program in (self._nearest, self._colour, *self._settle):
            self.gpu.barrier()
            self.set(program, H=forward.H, e=forward.e)
            if program in self._settle:  # dispatched indirectly, by what tied
                program.program.run_indirect(self._ties)
            else:
                program.program.run(*groups)
        if self._depth is not None:
            self.set(self._depth)
            self._depth.run(*self.shown_size)


# Pixels from the picture's middle beyond which an epipole counts as this far in its direction: rows
# of the largest picture then turn by at most 2^14 / 2^20 rad against the true lines, a pixel in 64,
# and the distance still fits into an integer.
FARTHEST = 2.0**20


@attrs.frozen
class _ForwardOrderedSettings:
    """The order in which rendered pixels are visited."""

    # rings: squares around the epipole, so that pixels of similar distance are compared. rows:
    # McMillan's quadrants, row by row.
    sheets: Literal["rings", "rows"] = chosen("rings", "rows")


@warps.register
class ForwardOrdered(OrderedScatter):
    """Scatter pixels as if one by one: towards the epipole, or away from it if moved back."""

    name = "forward_ordered"
    Settings = _ForwardOrderedSettings

    def defines(self) -> dict[str, object]:
        return {"RINGS": 1} if self.settings.sheets == "rings" else {}

    def order(self, inputs: PassInputs) -> dict[str, object]:
        backward = view_map(inputs.shown, self.shown_size, inputs.rendered.view, self.rendered_size)
        pixel, sense = epipole_pixel(backward.e, self.rendered_size)
        # The origin of the ranks: the greatest distance, or minus the least if running away.
        to_low, to_high = -pixel, np.array(self.rendered_size) - 1 - pixel
        greatest = np.maximum(np.abs(to_low), np.abs(to_high))
        least = np.where((to_low <= 0) & (to_high >= 0), 0, np.minimum(np.abs(to_low), np.abs(to_high)))
        if self.settings.sheets == "rings":
            greatest, least = np.full(2, greatest.max()), np.full(2, least.max())
        return {"epipole": tuple(pixel), "sense": sense, "start": tuple((greatest if sense > 0 else -least).tolist())}


def epipole_pixel(e: NDArray[np.float64], size: tuple[int, int]) -> tuple[NDArray[np.int64], int]:
    """Return the rendered pixel (x, y) that holds the shown eye, and 1 or -1.

    1: the shown eye lies ahead of the rendered one (run towards it); -1: behind.
    e: the shown eye in homogeneous pixels, view_map(shown, rendered).e. An epipole at
    infinity or beyond FARTHEST pixels is put that far away in its direction. Without a baseline any
    order is right, and the picture's middle is used.
    """
    middle = np.array(size) / 2
    sense = -1 if e[2] < 0 else 1
    offset = sense * (e[:2] - middle * e[2])  # times 1 / |e.z|, which may be 0
    length, depth = np.hypot(*offset), abs(e[2])
    if length > FARTHEST * depth:
        offset = offset / length * FARTHEST
    elif depth > 0:
        offset = offset / depth
    # An epipole on the border between two pixels counts to the upper one, despite rounding.
    return np.floor(middle + offset + 1e-6).astype(np.int64), sense


@warps.register
class ForwardRaster(OrderedScatter):
    """Scatter pixels as if row by row from the top, each from left to right; the last one wins."""

    name = "forward_raster"

    def order(self, inputs: PassInputs) -> dict[str, object]:
        return {}


@attrs.frozen
class _SplatSettings:
    """The size of footprints; what neighbours are one surface, by the pixel's own depth."""

    tolerance: float = limited(0.03)
    floor: float = limited(0.02)  # 1/m
    # Pixels that a footprint may extend from its middle. Beyond twice that magnification gaps
    # appear; one rendered pixel costs at most (2 reach + 1)^2 tests.
    reach: int = limited(16, 1, 256)
    # Rendered pixels by which each square is larger on each side, against cracks on curved
    # surfaces.
    overlap: float = limited(0.05, 0, 0.5)


@warps.register
class Splat(ScatterWarp):
    """Scatters the depth of each rendered pixel over its footprint, then fetches the colours back.

    The nearest depth wins; colours are fetched through that depth.
    """

    name = "splat"
    Settings = _SplatSettings

    def prepare(self) -> None:
        self._cover = self.gpu.shaders.compute("warps/splat.comp", grid="rendered", PASS=0)
        self._fetch = self.gpu.shaders.compute("warps/splat.comp", PASS=1, **self.depth_defines)
        self._keys = self.empty_keys()

    def run(self, inputs: PassInputs, into: Canvas) -> None:
        self.bind(inputs, into)
        self._keys.bind_to_storage_buffer(0)
        s = self.settings
        limits = {**depth_limits(s, inputs.rendered), "reach": float(s.reach), "overlap": s.overlap}
        backward = view_map(inputs.shown, self.shown_size, inputs.rendered.view, self.rendered_size)
        passes = ((self._cover, self.forward_map(inputs), self.rendered_size), (self._fetch, backward, self.shown_size))
        for program, warp_map, size in passes:
            self.gpu.barrier()
            H, e = warp_map.H, warp_map.e
            if warp_map.moves_whole_pixels():  # each is then fetched from its very centre
                H, e = np.round(H), np.zeros(3)
            self.set(program, H=H, e=e, **limits)
            program.run(*size)
