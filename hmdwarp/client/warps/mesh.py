"""The rendered picture as a mesh of triangles: of a grid, or of cells where it is flat."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from math import sqrt
from typing import Any, ClassVar, Literal

import attrs
import moderngl
import numpy as np

from ...base import InputError, MachineError
from ...frames import EyeImage
from ...geometry import View, WarpMap, view_map
from ...gpu import Compute, Gpu
from ...gpu.textures import COLOUR, Canvas, Owner, allocate, bind_images, drawing_into
from ..inputs import PassInputs
from ..settings import chosen, limited
from . import warps
from ._base import Warp, pixel_of
from .gather import bind_rendered_colour


class _MeshTarget(Owner):
    """A framebuffer of the shown size."""

    def __init__(self, gpu: Gpu, shown_size: tuple[int, int]) -> None:
        self._gpu, self._gl = gpu, gpu.gl
        colour = self.own(allocate(gpu.gl, shown_size, COLOUR))
        depth = self.own(gpu.gl.depth_renderbuffer(shown_size))
        self._framebuffer = self.own(gpu.gl.framebuffer([colour], depth))

    @contextmanager
    def drawing(self, shown: View) -> Iterator[None]:
        """Clear it, and draw what faces the eye and is seen; larger depth values are nearer."""
        with drawing_into(self._framebuffer, moderngl.DEPTH_TEST | moderngl.CULL_FACE):
            self._framebuffer.clear(depth=0.0)
            self._gl.depth_func = ">"
            self._gpu.shaders.hidden.cover(shown, self._framebuffer, 1.0, COLOUR=1)
            yield
            self._gl.depth_func = "<"

    def copy_to(self, into: Canvas) -> None:
        """Copy the colour."""
        into.copy_from(self._framebuffer)


# 1/m by which the nearest of the ring must be nearer than the vertex. openwarp compares its clip
# depths, -1 at 0.1 m and 1 at 20 m, with 0.01; those are linear in inverse depth.
STEP = 0.01 / (2 * 0.1 * 20 / (20 - 0.1))


class GridMesh(Owner):
    """side x side vertices, from border to border, and two triangles between each four.

    A vertex lies at the depth of its pixel. Where one of six pixels in a ring around it is clearly
    nearer it lies at that one's depth, so that a surface takes along what is beside its edge.
    """

    def __init__(
        self, gpu: Gpu, rendered_size: tuple[int, int], shown_size: tuple[int, int], side: int, ring: float
    ) -> None:
        self._rendered_size, self._shown_size, self._side = rendered_size, shown_size, side
        self._ring = ring_px(ring, rendered_size)
        self._draw = gpu.shaders.draw("warps/mesh_grid.vert", "warps/mesh_cells.frag", ADAPTIVE=0, PIECES=0, VERTEX=0)
        y, x = (part.reshape(-1, 1) for part in np.mgrid[: side - 1, : side - 1])
        corners = y * side + x + np.array([0, 1, side, side, 1, side + 1])  # two triangles, both turning to the left
        indices = self.own(gpu.gl.buffer(corners.astype(np.uint32).tobytes()))
        array = gpu.gl.vertex_array(self._draw.program, [], index_buffer=indices, index_element_size=4)
        self._array, self._target = self.own(array), self.own(_MeshTarget(gpu, shown_size))

    def run(self, inputs: PassInputs, into: Canvas) -> None:
        """Draw one eye's picture."""
        forward = view_map(inputs.rendered.view, self._rendered_size, inputs.shown, self._shown_size)
        named = _drawn_with(inputs.rendered, forward, self._rendered_size, self._shown_size)
        self._draw.uniforms.set_declared(side=self._side, ring=self._ring, nearer=STEP, **named)
        with self._target.drawing(inputs.shown):
            self._array.render(moderngl.TRIANGLES)
        self._target.copy_to(into)


def _drawn_with(
    rendered: EyeImage, forward: WarpMap, rendered_size: tuple[int, int], shown_size: tuple[int, int]
) -> dict[str, object]:
    """Bind a rendered picture for shaders that draw it; return their uniforms."""
    bind_rendered_colour(rendered, 0, whole_pixels=forward.moves_whole_pixels())
    sizes = {"rendered_size": rendered_size, "shown_size": shown_size, "rendered_pixel": pixel_of(rendered_size)}
    units = bind_images({"rendered_inverse_depth": rendered.inverse_depth})
    return {"H": forward.H, "e": forward.e, "rendered_colour": 0, **sizes, **units}


def ring_px(ring: float, size: tuple[int, int]) -> tuple[int, int, int, int]:
    """Return the pixels to the ring along x and y, and along both for its two diagonal places.

    ring: as a share of the picture; a ring is at least one pixel away, unless it is 0.
    """
    straight, slanted = ring, sqrt(2) * ring
    x, y, across, up = (max(int(far * side + 0.5), 1) if ring else 0 for far in (straight, slanted) for side in size)
    return x, y, across, up


VERTEX_BLOCKS, BINDINGS = 2, 10  # buffers that the vertex shaders read, and all that are bound
MOST_SIDE = 2**14 - 2  # a cell's index has 14 bits a side, and there is one more cell than pixels
QUADS = 2**14  # in one draw: a corner's index has 16 bits
GROUP, BLOCK, SHIFT = 16, 4, 15  # as in shaders/warps/mesh_surface.glsl
BLOCK_BYTES, CALL_BYTES = 24, 20
CHUNK = 8  # as in shaders/warps/mesh_draws.glsl


class MeshWarp(Warp):
    """A warp that draws cells between pixel centres.

    Whole cells are two triangles, cut ones are drawn in quarters. Settings have `steepest_deg`: the
    angle from facing up to which a plane counts as one surface from one pixel to the next.
    """

    kind = "scatter"
    reads = ("rendered.colour", "rendered.inverse_depth")
    adaptive: ClassVar[bool]  # Whether cells merge where that moves little.

    def prepare(self) -> None:
        info, (wide, high) = self.gpu.gl.info, self.rendered_size
        # GL 4.3 does not guarantee that vertex shaders can read buffers.
        blocks, bindings = info["GL_MAX_VERTEX_SHADER_STORAGE_BLOCKS"], info["GL_MAX_SHADER_STORAGE_BUFFER_BINDINGS"]
        if blocks < VERTEX_BLOCKS or bindings < BINDINGS:
            raise MachineError(
                f"vertex shaders of this GPU read {blocks} buffers, and {bindings} can be bound: '{self.name}' wants "
                f"{VERTEX_BLOCKS} and {BINDINGS}; use warp 'splat'"
            )
        if max(wide, high) > MOST_SIDE:
            most = f"'{self.name}' takes at most {MOST_SIDE} pixels a side"
            raise InputError(f"a rendered picture of {wide}x{high}: {most}")
        (slope, vertex), adaptive = map(int, self.cuts), int(self.adaptive)
        shaders, gl = self.gpu.shaders, self.gpu.gl
        self._blocks = shaders.compute("warps/mesh_blocks.comp", ADAPTIVE=adaptive, SLOPE=slope)
        self._merge = shaders.compute("warps/mesh_merge.comp", ADAPTIVE=adaptive)
        self._order = shaders.compute("warps/mesh_order.comp", CHUNKS=0)
        self._list = shaders.compute("warps/mesh_list.comp")
        if self.adaptive:
            self._count, self._choose = (
                shaders.compute("warps/mesh_triangles.comp", STAGE=stage) for stage in range(2)
            )
            self._order_triangles = shaders.compute("warps/mesh_order.comp", CHUNKS=1)
        self._cells, self._pieces = (
            shaders.draw(f"{path}.vert", f"{path}.frag", ADAPTIVE=adaptive, PIECES=pieces, VERTEX=vertex)
            for pieces, path in enumerate(("warps/mesh_cells", "warps/mesh_pieces"))
        )
        cells = (wide + 1) * (high + 1)
        self._groups = tuple((side + SHIFT + GROUP) // GROUP for side in self.rendered_size)
        groups = self._groups[0] * self._groups[1]
        self._calls = -(-cells // QUADS), 1 if self.adaptive else -(-4 * cells // QUADS)
        chunks = -(-cells // CHUNK)
        # Blocks, groups, draws of cells and of pieces, cells, cut cells, the dispatch over them;
        # their triangles, chunks and masks.
        sizes = [
            groups * (GROUP // BLOCK) ** 2 * BLOCK_BYTES,
            8 * groups,
            *(CALL_BYTES * n for n in self._calls),
            8 * cells,
            4 * cells,
            16,
        ]
        if self.adaptive:
            sizes += [32 * cells, 4 * chunks, 8 * chunks]
        if max(sizes) > (limit := gl.info["GL_MAX_SHADER_STORAGE_BLOCK_SIZE"]):
            wanted = f"a rendered picture of {wide}x{high}: '{self.name}' needs a buffer of {max(sizes)} bytes"
            raise InputError(f"{wanted}, this GPU has room for {limit}")
        # Bound as they are numbered in the shaders.
        self._buffers = [self.own(gl.buffer(reserve=size)) for size in sizes]
        corners = 4 * np.arange(QUADS)[:, None] + np.array([0, 1, 2, 2, 1, 3])
        indices = self.own(gl.buffer(corners.astype(np.uint16).tobytes()))
        drawn = (self._cells.program, indices), (self._pieces.program, None if self.adaptive else indices)
        self._arrays = [
            self.own(gl.vertex_array(program, [], index_buffer=by, index_element_size=2)) for program, by in drawn
        ]
        self._target = self.own(_MeshTarget(self.gpu, self.shown_size))

    @property
    def cuts(self) -> tuple[bool, bool]:
        """Whether sheets between surfaces are cut by slope, and by vertex identity."""
        return True, False

    @property
    def merging(self) -> dict[str, Any]:
        """Uniforms of the shaders that merge: tolerance in shown pixels and coarsest cell."""
        return {}

    def run(self, inputs: PassInputs, into: Canvas) -> None:
        rendered, shown = inputs.rendered, inputs.shown
        forward = view_map(rendered.view, self.rendered_size, shown, self.shown_size)
        back = view_map(shown, self.shown_size, rendered.view, self.rendered_size)
        for binding, buffer in enumerate(self._buffers):
            buffer.bind_to_storage_buffer(binding)
        named = _drawn_with(rendered, forward, self.rendered_size, self.shown_size)
        named |= {"steepest": steepest(rendered.view, self.rendered_size, self.settings.steepest_deg)}
        named |= {"reach": reach(forward, self.shown_size), "group_count": self._groups[0] * self._groups[1]}
        named |= {"draws": self._calls, "draw_quads": QUADS, **self.merging}
        named |= {"rendered_from_shown": back.H, "rendered_parallax": back.e}
        named |= {"overlap": overlap(self.merging.get("tolerance", 0.0))}
        side = GROUP // BLOCK
        blocks = self._groups[0] * side, self._groups[1] * side
        passes: list[tuple[Compute, Callable[[], None]]] = [
            (program, partial(program.run, *size))
            for program, size in (
                (self._blocks, blocks),
                (self._merge, self._groups),
                (self._order, (1, 1)),
                (self._list, blocks),
            )
        ]
        if self.adaptive:
            passes += [(self._count, partial(self._count.program.run_indirect, self._buffers[6]))]
            passes += [(self._order_triangles, partial(self._order_triangles.run, 1))]
            passes += [(self._choose, partial(self._choose.program.run_indirect, self._buffers[6]))]
        for program, dispatch in passes:
            program.uniforms.set_declared(**named)
            dispatch()
            self.gpu.barrier()
        with self._target.drawing(shown):
            draws = (self._cells, self._pieces), self._arrays, self._buffers[2:4], self._calls
            for draw, array, calls, count in zip(*draws, strict=True):
                draw.uniforms.set_declared(**named)
                array.render_indirect(calls, moderngl.TRIANGLES, count=count)
        self._target.copy_to(into)


def steepest(rendered: View, size: tuple[int, int], angle_deg: float) -> tuple[float, float]:
    """Return the largest change of a plane's inverse depth from pixel to pixel, on each axis.

    It is relative to the inverse depth itself, for a plane seen `angle_deg` from facing. A plane's
    inverse depth is linear in the tangent of the view; facing the eye at the middle of the picture
    it grows by tan(angle) of itself for each 1 of tangent.
    """
    left, right, down, up = rendered.fov.tangents
    slope = float(np.tan(np.deg2rad(angle_deg)))
    return slope * (right - left) / size[0], slope * (up - down) / size[1]


def reach(forward: WarpMap, shown_size: tuple[int, int]) -> float:
    """Return the largest motion of a point, in shown pixels, per 1/m of inverse depth.

    At equal depths in both views its place P moves along e - P e_z.
    """
    wide, high = shown_size
    corners = np.array([[0, 0], [wide, 0], [0, high], [wide, high]])
    return float(np.linalg.norm(forward.e[:2] - corners * forward.e[2], axis=1).max())


def overlap(tolerance: float) -> float:
    """Return the rendered pixels by which large cells overlap their neighbours.

    Both may be off by the tolerance, and the rasteriser by 1/256.
    """
    return min(2 * tolerance + 1 / 32, 0.5)


STEEPEST_DEG = 85.0
MOST_VERTICES = 1024  # a side: a vertex's index times the picture's side stays below 2^24
RING = 0.005  # of the picture; openwarp's program sets one cell of its grid


@attrs.frozen
class _MeshSettings:
    """Where the mesh is cut; or, with a grid, how it is stretched."""

    cut: Literal["slope", "vertex", "both"] = chosen("slope", "vertex", "both")  # How sheets are found.
    # Planes seen at up to this angle from facing stay whole.
    steepest_deg: float = attrs.field(default=STEEPEST_DEG, validator=[attrs.validators.gt(0), attrs.validators.lt(90)])
    # Vertices on each axis of a mesh that is stretched across edges; 0 for one at each pixel, cut.
    grid: int = 0
    # Share of the picture at which a grid's vertex looks around itself for a nearer surface to lie
    # on; 0 for its own depth.
    ring: float = limited(RING, 0, 0.5)

    def __attrs_post_init__(self) -> None:
        if self.grid != 0 and not 2 <= self.grid <= MOST_VERTICES:
            raise ValueError(f"grid is {self.grid}: expected 2 to {MOST_VERTICES} vertices a side, or 0 for none")
        if self.grid and (self.cut, self.steepest_deg) != ("slope", STEEPEST_DEG):
            raise ValueError(f"grid={self.grid} is stretched across edges: leave out cut and steepest_deg, or the grid")
        if not self.grid and self.ring != RING:
            raise ValueError(f"ring is {self.ring:g}, but only a grid has one: give grid too, or leave it out")


@warps.register
class Mesh(MeshWarp):
    """A mesh with a vertex a pixel, cut between surfaces, or with a grid of fewer, which is not."""

    name = "mesh"
    Settings = _MeshSettings
    baselines = {"grid=64": "CloudXR.js", "grid=512,ring=0.002": "ILLIXR openwarp"}
    adaptive = False

    @property
    def cuts(self) -> tuple[bool, bool]:
        return self.settings.cut != "vertex", self.settings.cut != "slope"

    def prepare(self) -> None:
        chosen = self.settings
        if chosen.grid:
            self._grid = self.own(GridMesh(self.gpu, self.rendered_size, self.shown_size, chosen.grid, chosen.ring))
        else:
            super().prepare()

    def run(self, inputs: PassInputs, into: Canvas) -> None:
        if self.settings.grid:
            self._grid.run(inputs, into)
        else:
            super().run(inputs, into)


@attrs.frozen
class _MeshAdaptiveSettings:
    """How far cells are merged."""

    tolerance: float = limited(0.05)  # Shown pixels by which merging may displace a point.
    # Pixels on a side of the largest cell.
    block: int = attrs.field(default=16, validator=attrs.validators.in_((1, 2, 4, 8, 16)))
    # Planes seen at up to this angle from facing stay whole.
    steepest_deg: float = attrs.field(default=STEEPEST_DEG, validator=[attrs.validators.gt(0), attrs.validators.lt(90)])


@warps.register
class MeshAdaptive(MeshWarp):
    """`mesh` with cells of up to 16x16 pixels where this motion stays within the tolerance."""

    name = "mesh_adaptive"
    Settings = _MeshAdaptiveSettings
    adaptive = True

    @property
    def merging(self) -> dict[str, Any]:
        return {"tolerance": self.settings.tolerance, "coarsest": self.settings.block}
