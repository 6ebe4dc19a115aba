"""Surfaces cut along the cells of a regular grid."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import attrs
import numpy as np
from numpy.typing import NDArray

from ._mesh import Mesh
from ._scene import Scene
from .radiosity import lit_meshes, mean_colour, moved_meshes

Array = NDArray[np.float64]
_ON_PLANE = 1e-9  # cells by which a corner may pass a plane and still lie on it
_NORMAL_STEPS = 16  # pieces of one cell whose normals agree to 1 / 16 are one


@attrs.frozen(eq=False)
class VoxelGrid:
    """A cube of `size` cells a side around all surfaces that stand still and that lamps light.

    The outermost lie in the middle of a cell, with a cell to spare: no rounding puts them in two.
    What moves beyond counts in the outermost cells.
    """

    low: Array  # (3,) its lowest corner, metres from the scene's origin
    cell_m: float
    size: int

    @classmethod
    def around(cls, scene: Scene, size: int) -> VoxelGrid:
        """Return the grid of a scene; one of a metre where nothing is lit."""
        corners = np.concatenate([np.zeros((0, 3)), *(mesh.positions for mesh in lit_meshes(scene.meshes))])
        low, high = (corners.min(axis=0), corners.max(axis=0)) if len(corners) else (np.zeros(3), np.ones(3))
        cell_m = max(float((high - low).max()), 1e-6) / (size - 3)
        return cls((low + high) / 2 - cell_m * size / 2, cell_m, size)


@attrs.frozen(eq=False)
class VoxelSurfaces:
    """What lies in the cells: for each cell and each way a surface faces there, one piece."""

    cells: NDArray[np.int64]  # (n,) x + size * (y + size * z), ascending
    places: Array  # (n, 3) the middle of each, metres from the scene's origin
    normals: Array  # (n, 3)
    areas: Array  # (n,) in faces of a cell
    albedo: Array  # (n, 3) linear

    def __len__(self) -> int:
        return len(self.cells)


def voxel_surfaces(scene: Scene, grid: VoxelGrid, time_ns: int = 0) -> VoxelSurfaces:
    """Return all lit surfaces at an instant, cut along the cells; no area is lost."""
    return _merged(
        np.concatenate([_still_pieces(scene, grid), _pieces(scene, moved_meshes(scene, time_ns), grid)]), grid
    )


@lru_cache(maxsize=2)
def _still_pieces(scene: Scene, grid: VoxelGrid) -> Array:
    return _pieces(scene, lit_meshes(scene.meshes), grid)


def _pieces(scene: Scene, meshes: Sequence[Mesh], grid: VoxelGrid) -> Array:
    """Return (n, 3, 9) triangles: places in cells, normals and albedo of the corners."""
    kinds = [np.zeros((0, 3, 9))]
    for mesh in meshes:
        albedo = mesh.albedo if mesh.albedo is not None else np.full_like(mesh.positions, 0.5)
        texture = mean_colour(scene.textures[mesh.texture]) if mesh.texture >= 0 else np.ones(3)
        places = (mesh.positions.astype(np.float64) - grid.low) / grid.cell_m
        kinds.append(np.concatenate([places, mesh.normals, albedo * texture], axis=1)[mesh.triangles])
    pieces = np.concatenate(kinds)
    for axis in range(3):
        pieces = _cut(pieces, axis)
    return pieces


def _cut(pieces: Array, axis: int) -> Array:
    """Return (n, 3, k) triangles of which none crosses a whole number on that axis."""
    whole = []
    while len(pieces):
        along = pieces[..., axis]
        first = np.floor(along.min(axis=1) + _ON_PLANE)
        crossed = np.ceil(along.max(axis=1) - _ON_PLANE) - first - 1
        whole.append(pieces[crossed <= 0])
        pieces, middle = pieces[crossed > 0], (first + 1 + crossed // 2)[crossed > 0]
        pieces = _halves(pieces, axis, middle)
    return np.concatenate([np.zeros((0, *pieces.shape[1:])), *whole])


def _halves(pieces: Array, axis: int, planes: Array) -> Array:
    """Return the triangles cut in two along a plane each, which crosses them."""
    order = np.argsort(pieces[..., axis], axis=1, kind="stable")
    a, b, c = np.take_along_axis(pieces, order[..., None], axis=1).transpose(1, 0, 2)

    def on_plane(p: Array, q: Array, where: Array) -> Array:
        share = ((where - p[:, axis]) / (q[:, axis] - p[:, axis]))[:, None]
        cut = p + share * (q - p)
        cut[:, axis] = where
        return cut

    far = on_plane(a, c, planes)
    below = b[:, axis] <= planes
    out = []
    for alone, other, pair, chosen in ((c, a, b, below), (a, c, b, ~below)):
        lone, end, mid, cut = alone[chosen], other[chosen], pair[chosen], far[chosen]
        near = np.where((mid[:, axis] == planes[chosen])[:, None], mid, 0)
        crossing = mid[:, axis] != planes[chosen]
        near[crossing] = on_plane(mid[crossing], lone[crossing], planes[chosen][crossing])
        out += [np.stack(corners, axis=1) for corners in ((lone, near, cut), (end, mid, near), (end, near, cut))]
    return np.concatenate(out)


def _merged(pieces: Array, grid: VoxelGrid) -> VoxelSurfaces:
    """Return the pieces of each cell that face the same way as one."""
    a, b, c = pieces[..., :3].transpose(1, 0, 2)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    pieces, areas = pieces[areas > 0], areas[areas > 0]
    middle = pieces.mean(axis=1)
    cells = np.clip(np.floor(middle[:, :3]).astype(np.int64), 0, grid.size - 1) @ grid.size ** np.arange(3)
    ways = np.rint((1 + np.clip(middle[:, 3:6], -1, 1)) * _NORMAL_STEPS).astype(np.int64)
    several = 2 * _NORMAL_STEPS + 1
    kept, which = np.unique(cells * several**3 + ways @ several ** np.arange(3), return_inverse=True)
    columns = np.column_stack([areas, areas[:, None] * middle]).T
    total: Array = np.stack([np.bincount(which, column, len(kept)) for column in columns], axis=1).astype(np.float64)
    means = total[:, 1:] / total[:, :1]
    normals = means[:, 3:6] / np.maximum(np.linalg.norm(means[:, 3:6], axis=1, keepdims=True), 1e-12)
    places = grid.low + grid.cell_m * means[:, :3]
    return VoxelSurfaces(kept // several**3, places, normals, total[:, 0], means[:, 6:9])
