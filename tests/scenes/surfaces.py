"""Flat surfaces cut into cells, for tests that need many triangles of a known shape."""

from __future__ import annotations

from collections.abc import Sequence

import attrs
import numpy as np


@attrs.frozen(eq=False)
class Surface:
    positions: np.ndarray
    normals: np.ndarray
    uv: np.ndarray
    triangles: np.ndarray


def patch(corner, edge_u, edge_v, cell_m: float = 0.25) -> Surface:
    """A parallelogram with vertices every `cell_m`, its front where edge_u x edge_v points."""
    corner, edge_u, edge_v = (np.asarray(vector, float) for vector in (corner, edge_u, edge_v))
    lengths = np.linalg.norm(edge_u), np.linalg.norm(edge_v)
    u, v = (np.linspace(0, 1, max(1, round(length / cell_m)) + 1) for length in lengths)
    vv, uu = (grid.reshape(-1, 1) for grid in np.meshgrid(v[::-1], u, indexing="ij"))
    positions = corner + uu * edge_u + vv * edge_v
    normal = np.cross(edge_u, edge_v) / np.prod(lengths)
    index = np.arange(len(uu)).reshape(len(v), len(u))
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    triangles = np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3)
    return Surface(positions, np.tile(normal, (len(uu), 1)), np.hstack([uu, vv]) * lengths, triangles)


def box(centre, size, cell_m: float = 0.3) -> Surface:
    """The six patches of a box of full `size`."""
    x, y, z = np.diag(np.asarray(size, float))
    low = np.asarray(centre, float) - (x + y + z) / 2
    faces = ((low + z, x, y), (low + x, -x, y), (low + x + z, -z, y), (low, z, y), (low + y + z, x, -z), (low, x, z))
    return join([patch(*face, cell_m=cell_m) for face in faces])


def join(surfaces: Sequence[Surface]) -> Surface:
    """Several surfaces as one."""
    starts = np.cumsum([0, *(len(surface.positions) for surface in surfaces)])
    names = ("positions", "normals", "uv")
    return Surface(
        *(np.concatenate([getattr(surface, name) for surface in surfaces]) for name in names),
        np.concatenate([s.triangles + start for s, start in zip(surfaces, starts[:-1], strict=True)]),
    )
