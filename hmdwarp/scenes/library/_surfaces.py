"""Curved and flat surfaces from a few numbers: every one is a grid of points turned into triangles."""

from __future__ import annotations

from collections.abc import Sequence

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._shapes import grid_triangles

Points = NDArray[np.float64]


@attrs.frozen(eq=False)
class Surface:
    """positions, normals (n, 3), uv (n, 2), triangles (m, 3); not yet coloured."""

    positions: Points
    normals: Points
    uv: Points
    triangles: NDArray[np.uint32]

    def moved(self, offset: ArrayLike, turn_y: float = 0.0) -> Surface:
        """Turned by `turn_y` radians about the y axis, then moved by `offset` metres."""
        c, s = np.cos(turn_y), np.sin(turn_y)
        turn = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
        return attrs.evolve(self, positions=self.positions @ turn.T + np.asarray(offset), normals=self.normals @ turn.T)


def join(surfaces: Sequence[Surface]) -> Surface:
    """Several surfaces as one."""
    starts = np.cumsum([0, *(len(s.positions) for s in surfaces)])
    return Surface(
        np.concatenate([s.positions for s in surfaces]),
        np.concatenate([s.normals for s in surfaces]),
        np.concatenate([s.uv for s in surfaces]),
        np.concatenate([s.triangles + np.uint32(start) for s, start in zip(surfaces, starts, strict=False)]),
    )


def sheet(points: Points, uv: Points, *, wraps: bool = False) -> Surface:
    """A (rows, columns, 3) grid of points with (rows, columns, 2) uv; its front is where next row x next column points.

    wraps: the last column lies on the first one, so that normals run on across the seam.
    """
    along_rows = np.gradient(points, axis=0)
    if wraps:
        ring = np.concatenate([points[:, -2:-1], points, points[:, 1:2]], axis=1)
        along_columns = (ring[:, 2:] - ring[:, :-2]) / 2
    else:
        along_columns = np.gradient(points, axis=1)
    normals = np.cross(along_rows, along_columns).reshape(-1, 3)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    return Surface(points.reshape(-1, 3), normals, uv.reshape(-1, 2), grid_triangles(*points.shape[:2]))


def _outward(surface: Surface) -> Surface:
    """A closed surface turned so that its front is outside (the sign of its volume)."""
    a, b, c = (surface.positions[surface.triangles[:, i]] for i in range(3))
    if np.einsum("ij,ij->", a, np.cross(b, c)) >= 0:
        return surface
    return attrs.evolve(surface, normals=-surface.normals, triangles=surface.triangles[:, ::-1])


def patch(
    corner: ArrayLike,
    edge_u: ArrayLike,
    edge_v: ArrayLike,
    *,
    cell_m: float = 0.25,
    tile_m: float = 1.0,
    uv: ArrayLike | None = None,
) -> Surface:
    """A parallelogram with vertices every `cell_m`, its front where edge_u x edge_v points.

    uv counts tiles of `tile_m` metres, or spans `uv` (u0, v0, u1, v1).
    """
    corner, edge_u, edge_v = (np.asarray(x, dtype=np.float64) for x in (corner, edge_u, edge_v))
    lengths = np.linalg.norm(edge_u), np.linalg.norm(edge_v)
    u, v = (np.linspace(0, 1, max(1, round(length / cell_m)) + 1) for length in lengths)
    vv, uu = np.meshgrid(v[::-1], u, indexing="ij")
    points = corner + uu[..., None] * edge_u + vv[..., None] * edge_v
    u0, v0, u1, v1 = (0, 0, lengths[0] / tile_m, lengths[1] / tile_m) if uv is None else uv
    return sheet(points, np.stack([u0 + uu * (u1 - u0), v0 + vv * (v1 - v0)], axis=-1))


def box(
    centre: ArrayLike,
    size: ArrayLike,
    *,
    cell_m: float = 0.3,
    tile_m: float = 1.0,
    without: str = "",
    uv: ArrayLike | None = None,
) -> Surface:
    """A box of full `size`; `without` names faces to leave out (of -x +x -y +y -z +z, as in "-y+z"), such as those on a wall."""
    c, (sx, sy, sz) = np.asarray(centre, dtype=np.float64), size
    x, y, z = np.array([sx, 0, 0.0]), np.array([0, sy, 0.0]), np.array([0, 0, sz])
    low = c - (x + y + z) / 2
    faces = {
        "+z": (low + z, x, y),
        "-z": (low + x, -x, y),
        "+x": (low + x + z, -z, y),
        "-x": (low, z, y),
        "+y": (low + y + z, x, -z),
        "-y": (low, x, z),
    }
    return join(
        [patch(*face, cell_m=cell_m, tile_m=tile_m, uv=uv) for name, face in faces.items() if name not in without]
    )


def tube(points: ArrayLike, radius: ArrayLike, *, sides: int = 8, tile_m: float = 0.2) -> Surface:
    """A round rod along (k, 3) points; radius one number or (k,). Its ends are open: let them end inside something."""
    points = np.asarray(points, dtype=np.float64)
    tangent = np.gradient(points, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    # The helper axis least along the whole rod never lines up with it, so the frame does not flip on the way.
    helper = np.eye(3)[np.argmin(np.abs(tangent).max(axis=0))]
    side = np.cross(tangent, helper)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    other = np.cross(tangent, side)
    angle = np.linspace(0, 2 * np.pi, sides + 1)
    radius = np.broadcast_to(np.asarray(radius, dtype=np.float64), len(points))[:, None, None]
    ring = side[:, None] * np.cos(angle)[:, None] + other[:, None] * np.sin(angle)[:, None]
    along = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))]) / tile_m
    around = np.broadcast_to(np.linspace(0, 1, sides + 1), (len(points), sides + 1))
    made = sheet(
        points[:, None] + radius * ring,
        np.stack([around, np.broadcast_to(along[:, None], around.shape)], axis=-1),
        wraps=True,
    )
    inward = np.einsum("ij,ij->", made.normals, ring.reshape(-1, 3)) < 0
    return attrs.evolve(made, normals=-made.normals, triangles=made.triangles[:, ::-1]) if inward else made


def lathe(
    profile: ArrayLike, centre: ArrayLike = (0, 0, 0), *, sides: int = 24, repeats: float = 2.0, tile_m: float = 0.2
) -> Surface:
    """A (k, 2) profile of (radius, height) turned about the vertical through `centre`; listed from the bottom, outside in."""
    profile = np.asarray(profile, dtype=np.float64)
    angle = np.linspace(0, 2 * np.pi, sides + 1)
    radius, height = np.maximum(profile[:, :1], 1e-4), np.broadcast_to(profile[:, 1:], (len(profile), sides + 1))
    points = np.stack([radius * np.sin(angle), height, radius * np.cos(angle)], axis=-1)
    along = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(profile, axis=0), axis=1))]) / tile_m
    uv = np.stack(
        [np.broadcast_to(angle / (2 * np.pi) * repeats, height.shape), np.broadcast_to(along[:, None], height.shape)],
        axis=-1,
    )
    made = sheet(points, uv, wraps=True)
    # Listed from the bottom upwards on the outside, next row x next column points inwards.
    return attrs.evolve(
        made, normals=-made.normals, triangles=made.triangles[:, ::-1], positions=made.positions + np.asarray(centre)
    )


def cushion(
    centre: ArrayLike,
    size: ArrayLike,
    *,
    roundness: float = 0.35,
    rings: int = 10,
    sides: int = 20,
    tile_m: float = 0.3,
) -> Surface:
    """A superellipsoid of full `size`: a box with soft edges; roundness 1 is an ellipsoid, towards 0 a box. Source: Barr 1981."""

    def power(values: NDArray) -> NDArray:
        return np.sign(values) * np.abs(values) ** roundness

    lat = np.linspace(-1, 1, rings + 1) * (np.pi / 2 - 1e-3)  # the very poles have no normal
    lon = np.linspace(-np.pi, np.pi, sides + 1)
    aa, oo = np.meshgrid(lat, lon, indexing="ij")
    unit = np.stack(
        [power(np.cos(aa)) * power(np.cos(oo)), power(np.sin(aa)), power(np.cos(aa)) * power(np.sin(oo))], axis=-1
    )
    half = np.asarray(size, dtype=np.float64) / 2
    points = unit * half
    uv = np.stack(
        [(points[..., 0] + points[..., 2] * 0.7) / tile_m, (points[..., 1] + points[..., 2] * 0.7) / tile_m], axis=-1
    )
    made = _outward(sheet(points, uv, wraps=True))
    return attrs.evolve(made, positions=made.positions + np.asarray(centre))


def leaf(
    base: ArrayLike,
    direction: ArrayLike,
    *,
    length: float,
    width: float,
    droop: float,
    cells: int = 6,
    uv: ArrayLike = (0, 0, 1, 1),
) -> Surface:
    """A pointed leaf with a folded midrib that starts at `base` along `direction` and droops; two-sided."""
    base, direction = np.asarray(base, dtype=np.float64), np.asarray(direction, dtype=np.float64)
    direction = direction / np.linalg.norm(direction)
    across = np.cross(direction, [0, 1, 0])
    across = across / max(np.linalg.norm(across), 1e-9)
    up = np.cross(across, direction)
    t = np.linspace(0, 1, cells + 1)[:, None]
    half = width / 2 * np.sin(np.pi * np.clip(t, 0.015, 0.985) ** 0.75)
    spine = base + direction * (t * length) - np.array([0, 1.0, 0]) * droop * length * t**2
    points = np.stack([spine + across * (half * s) + up * (half * abs(s) * 0.35) for s in (-1.0, 0.0, 1.0)], axis=1)
    u0, v0, u1, v1 = uv
    grid_v, grid_u = np.meshgrid(np.linspace(v0, v1, cells + 1), np.linspace(u0, u1, 3), indexing="ij")
    return sheet(points, np.stack([grid_u, grid_v], axis=-1))


def catenary(start: ArrayLike, end: ArrayLike, sag: float, points: int = 40) -> Points:
    """(points, 3) along a hanging wire, `sag` metres below the line between its ends (a parabola, as for small sag)."""
    t = np.linspace(0, 1, points)[:, None]
    line = np.asarray(start, dtype=np.float64) * (1 - t) + np.asarray(end, dtype=np.float64) * t
    return line - np.array([0, 4 * sag, 0]) * t * (1 - t)
