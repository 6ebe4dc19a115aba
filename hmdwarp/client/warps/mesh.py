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
from numpy.typing import NDArray

from ...errors import InputError, MachineError
from ...geometry import View, WarpMap, view_map
from ...gpu.context import Gpu
from ...gpu.shaders import Compute
from ...gpu.textures import COLOUR, Canvas, allocate, drawing_into, release_all
from ..inputs import PassInputs
from . import warps
from ._base import Warp
from .gather import bind_rendered_colour


class MeshTarget:
    """A framebuffer of the shown size."""

    def __init__(self, gpu: Gpu, shown_size: tuple[int, int]) -> None:
        self._gpu, self._gl = gpu, gpu.gl
        self._colour = allocate(gpu.gl, shown_size, COLOUR)
        self._depth = gpu.gl.depth_renderbuffer(shown_size)
        self._framebuffer = gpu.gl.framebuffer([self._colour], self._depth)

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

    def close(self) -> None:
        """Free the textures."""
        release_all(self._framebuffer, self._colour, self._depth)


# 1/m by which the nearest of the ring must be nearer than the vertex. openwarp compares its clip
# depths, -1 at 0.1 m and 1 at 20 m, with 0.01; those are linear in inverse depth.
STEP = 0.01 / (2 * 0.1 * 20 / (20 - 0.1))


class GridMesh:
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
        self._indices = gpu.gl.buffer(_indices(side).tobytes())
        self._array = gpu.gl.vertex_array(self._draw.program, [], index_buffer=self._indices, index_element_size=4)
        self._target = MeshTarget(gpu, shown_size)

    def run(self, inputs: PassInputs, into: Canvas) -> None:
        """Draw one eye's picture."""
        rendered = inputs.rendered
        forward = view_map(rendered.view, self._rendered_size, inputs.shown, self._shown_size)
        rendered.inverse_depth.bind_to_image(0, read=True, write=False)
        bind_rendered_colour(rendered, 0, whole_pixels=forward.moves_whole_pixels())
        self._draw.uniforms.set_declared(
            H=forward.H,
            e=forward.e,
            rendered_size=self._rendered_size,
            shown_size=self._shown_size,
            rendered_pixel=(1 / self._rendered_size[0], 1 / self._rendered_size[1]),
            rendered_inverse_depth=0,
            rendered_colour=0,
            side=self._side,
            ring=self._ring,
            nearer=STEP,
        )
        with self._target.drawing(inputs.shown):
            self._array.render(moderngl.TRIANGLES)
        self._target.copy_to(into)

    def close(self) -> None:
        """Free the buffers."""
        release_all(self._array, self._indices)
        self._target.close()


def ring_px(ring: float, size: tuple[int, int]) -> tuple[int, int, int, int]:
    """Return the pixels to the ring along x and y, and along both for its two diagonal places.

    ring: as a share of the picture; a ring is at least one pixel away, unless it is 0.
    """
    straight, slanted = ring, sqrt(2) * ring
    x, y, across, up = (max(int(far * side + 0.5), 1) if ring else 0 for far in (straight, slanted) for side in size)
    return x, y, across, up


def _indices(side: int) -> NDArray[np.uint32]:
    """Return (cells, 6) vertices of the two triangles of each cell, both turning to the left."""
    y, x = (part.reshape(-1, 1) for part in np.mgrid[: side - 1, : side - 1])
    indices: NDArray[np.uint32] = (y * side + x + np.array([0, 1, side, side, 1, side + 1])).astype(np.uint32)
    return indices


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
            found = f"vertex shaders of this GPU read {blocks} buffers, and {bindings} can be bound"
            wanted = f"'{self.name}' wants {VERTEX_BLOCKS} and {BINDINGS}"
            raise MachineError(f"{found}: {wanted}; use warp 'splat' or 'search'")
        if max(wide, high) > MOST_SIDE:
            most = f"'{self.name}' takes at most {MOST_SIDE} pixels a side"
            raise InputError(f"a rendered picture of {wide}x{high}: {most}")
        slope, vertex = map(int, self.cuts)
        shaders, adaptive = self.gpu.shaders, int(self.adaptive)
        self._blocks = shaders.compute("warps/mesh_blocks.comp", ADAPTIVE=adaptive, SLOPE=slope)
        self._merge = shaders.compute("warps/mesh_merge.comp", ADAPTIVE=adaptive)
        self._order = shaders.compute("warps/mesh_order.comp", CHUNKS=0)
        self._list = shaders.compute("warps/mesh_list.comp")
        if self.adaptive:
            self._count, self._choose = (
                shaders.compute("warps/mesh_triangles.comp", STAGE=stage) for stage in range(2)
            )
            self._order_triangles = shaders.compute("warps/mesh_order.comp", CHUNKS=1)
        self._cells = shaders.draw(
            "warps/mesh_cells.vert", "warps/mesh_cells.frag", ADAPTIVE=adaptive, PIECES=0, VERTEX=vertex
        )
        self._pieces = shaders.draw(
            "warps/mesh_pieces.vert", "warps/mesh_pieces.frag", ADAPTIVE=adaptive, PIECES=1, VERTEX=vertex
        )
        gl = self.gpu.gl
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
        self._buffers = [gl.buffer(reserve=size) for size in sizes]  # bound as they are numbered in the shaders
        corners = 4 * np.arange(QUADS)[:, None] + np.array([0, 1, 2, 2, 1, 3])
        self._corners = gl.buffer(corners.astype(np.uint16).tobytes())
        self._arrays = [
            gl.vertex_array(self._cells.program, [], index_buffer=self._corners, index_element_size=2),
            gl.vertex_array(
                self._pieces.program, [], index_buffer=None if self.adaptive else self._corners, index_element_size=2
            ),
        ]
        self._target = MeshTarget(self.gpu, self.shown_size)

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
        rendered.inverse_depth.bind_to_image(0, read=True, write=False)
        for binding, buffer in enumerate(self._buffers):
            buffer.bind_to_storage_buffer(binding)
        named = {
            "H": forward.H,
            "e": forward.e,
            "rendered_size": self.rendered_size,
            "shown_size": self.shown_size,
            "rendered_inverse_depth": 0,
            "steepest": self._steepest(rendered.view),
            "reach": reach(forward, self.shown_size),
            "group_count": self._groups[0] * self._groups[1],
            "draws": self._calls,
            "draw_quads": QUADS,
            **self.merging,
        }
        side = GROUP // BLOCK
        blocks = self._groups[0] * side, self._groups[1] * side
        for program, size in (
            (self._blocks, blocks),
            (self._merge, self._groups),
            (self._order, (1, 1)),
            (self._list, blocks),
        ):
            self._run(program, named, partial(program.run, *size))
        if self.adaptive:
            self._run(self._count, named, lambda: self._count.program.run_indirect(self._buffers[6]))
            self._run(self._order_triangles, named, lambda: self._order_triangles.run(1))
            self._run(self._choose, named, lambda: self._choose.program.run_indirect(self._buffers[6]))
        bind_rendered_colour(rendered, 0, whole_pixels=forward.moves_whole_pixels())
        back = view_map(shown, self.shown_size, rendered.view, self.rendered_size)
        named = {
            "H": forward.H,
            "e": forward.e,
            "rendered_size": self.rendered_size,
            "shown_size": self.shown_size,
            "rendered_pixel": (1 / self.rendered_size[0], 1 / self.rendered_size[1]),
            "rendered_inverse_depth": 0,
            "rendered_colour": 0,
            "steepest": self._steepest(rendered.view),
            "rendered_from_shown": back.H,
            "rendered_parallax": back.e,
            "overlap": overlap(self.merging.get("tolerance", 0.0)),
        }
        with self._target.drawing(shown):
            for draw, array, calls, count in zip(
                (self._cells, self._pieces), self._arrays, self._buffers[2:4], self._calls, strict=True
            ):
                draw.uniforms.set_declared(**named)
                array.render_indirect(calls, moderngl.TRIANGLES, count=count)
        self._target.copy_to(into)

    def _run(self, program: Compute, named: dict[str, Any], dispatch: Callable[[], None]) -> None:
        program.uniforms.set_declared(**named)
        dispatch()
        self.gpu.barrier()

    def _steepest(self, rendered: View) -> tuple[float, float]:
        return steepest(rendered, self.rendered_size, self.settings.steepest_deg)

    def close(self) -> None:
        release_all(*self._arrays, self._corners, *self._buffers)
        self._target.close()


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
class MeshSettings:
    """Where the mesh is cut; or, with a grid, how it is stretched."""

    # How sheets between two surfaces are found.
    cut: Literal["slope", "vertex", "both"] = attrs.field(
        default="slope", validator=attrs.validators.in_(("slope", "vertex", "both"))
    )
    # Planes seen at up to this angle from facing stay whole.
    steepest_deg: float = attrs.field(default=STEEPEST_DEG, validator=[attrs.validators.gt(0), attrs.validators.lt(90)])
    # Vertices on each axis of a mesh that is stretched across edges; 0 for one at each pixel, cut.
    grid: int = 0
    # Share of the picture at which a grid's vertex looks around itself for a nearer surface to lie
    # on; 0 for its own depth.
    ring: float = attrs.field(default=RING, validator=[attrs.validators.ge(0), attrs.validators.le(0.5)])

    def __attrs_post_init__(self) -> None:
        if self.grid != 0 and not 2 <= self.grid <= MOST_VERTICES:
            raise ValueError(f"grid is {self.grid}: expected 2 to {MOST_VERTICES} vertices a side, or 0 for none")
        if self.grid and (self.cut, self.steepest_deg) != ("slope", STEEPEST_DEG):
            raise ValueError(f"grid={self.grid} is stretched across edges: leave out cut and steepest_deg, or the grid")
        if not self.grid and self.ring != RING:
            raise ValueError(f"ring is {self.ring:g}, but only a grid has one: give grid too, or leave it out")


@warps.register
class Mesh(MeshWarp):
    """A mesh with one vertex a pixel, or with a grid of fewer.

    Sheets between surfaces are cut by slope before they are drawn, by vertex identity after, or by
    either; those of a grid are not cut.
    """

    name = "mesh"
    summary = "draws the rendered picture as triangles between its pixels, cut where surfaces part"
    exact_when = (
        "surfaces are seen in the rendered picture and are smooth from one pixel to the next, up to one bilinear "
        "resample"
    )
    gets_wrong = (
        "what was hidden is a hole; every edge is half a pixel wide of the truth; slow where triangles are; with a "
        "grid, edges are off by up to a cell, and what was hidden shows colours stretched from beside it"
    )
    source = (
        "Mark, McMillan and Bishop 1997, Post-Rendering 3D Warping; Mark 1999 (thesis), 3.3; the grid: openwarp in "
        "Huzaifa et al. 2021, ILLIXR"
    )
    Settings = MeshSettings
    baselines = {"grid=64": "CloudXR.js", "grid=512,ring=0.002": "ILLIXR openwarp"}
    adaptive = False

    @property
    def cuts(self) -> tuple[bool, bool]:
        return self.settings.cut != "vertex", self.settings.cut != "slope"

    def prepare(self) -> None:
        chosen = self.settings
        if chosen.grid:
            self._grid = GridMesh(self.gpu, self.rendered_size, self.shown_size, chosen.grid, chosen.ring)
        else:
            super().prepare()

    def run(self, inputs: PassInputs, into: Canvas) -> None:
        if self.settings.grid:
            self._grid.run(inputs, into)
        else:
            super().run(inputs, into)

    def close(self) -> None:
        if self.settings.grid:
            self._grid.close()
        else:
            super().close()


BLOCKS = (1, 2, 4, 8, 16)


@attrs.frozen
class MeshAdaptiveSettings:
    """How far cells are merged."""

    # Shown pixels by which merging may displace a point.
    tolerance: float = attrs.field(default=0.05, validator=attrs.validators.ge(0))
    # Pixels on a side of the largest cell: 1, 2, 4, 8 or 16.
    block: int = attrs.field(default=16, validator=attrs.validators.in_(BLOCKS))
    # Planes seen at up to this angle from facing stay whole.
    steepest_deg: float = attrs.field(default=STEEPEST_DEG, validator=[attrs.validators.gt(0), attrs.validators.lt(90)])


@warps.register
class MeshAdaptive(MeshWarp):
    """`mesh` with cells of up to 16x16 pixels where this motion stays within the tolerance."""

    name = "mesh_adaptive"
    summary = (
        "as mesh, with few large triangles where the surface is flat: the same picture within a twentieth of a pixel"
    )
    exact_when = "as mesh, up to the tolerance (in shown pixels)"
    gets_wrong = "as mesh; detail in depth below the tolerance is flattened"
    source = (
        "Schollmeyer et al. 2017, Efficient Hybrid Image Warping; "
        "Reinert et al. 2016, Proxy-guided Image-based Rendering"
    )
    Settings = MeshAdaptiveSettings
    adaptive = True

    @property
    def merging(self) -> dict[str, Any]:
        return {"tolerance": self.settings.tolerance, "coarsest": self.settings.block}
