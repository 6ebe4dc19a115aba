"""A mesh with few vertices, evenly spread over the rendered picture and stretched across edges."""

from __future__ import annotations

from math import sqrt
from typing import TYPE_CHECKING

import moderngl
import numpy as np

from ...geometry import WarpMap
from ...gpu.textures import release_all
from .gather import bind_rendered_colour
from .mesh_target import MeshTarget

if TYPE_CHECKING:
    from ...gpu.context import Gpu
    from ...gpu.textures import Canvas
    from ..inputs import PassInputs

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
        forward = WarpMap.between(rendered.view, self._rendered_size, inputs.shown, self._shown_size)
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
        with self._target.drawing():
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


def _indices(side: int) -> np.ndarray:
    """Return (cells, 6) vertices of the two triangles of each cell, both turning to the left."""
    y, x = (part.reshape(-1, 1) for part in np.mgrid[: side - 1, : side - 1])
    return (y * side + x + np.array([0, 1, side, side, 1, side + 1])).astype(np.uint32)
