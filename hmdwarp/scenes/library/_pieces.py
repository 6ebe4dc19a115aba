"""Pieces of a scene on their way from surfaces to meshes: painted one by one, lit together, merged for few draw calls."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import attrs
import numpy as np
from numpy.typing import NDArray

from .._model import Mesh
from ._surfaces import Surface

INSIDE, OUTSIDE, GLOWING = "inside", "outside", "glowing"
SECTORS = 12  # of the full turn around the viewer: what lies behind the head is left out in a few whole meshes


@attrs.frozen(eq=False)
class Piece:
    """A surface with its texture name and linear `tint`; `shades`: whether it casts shadows in the bake."""

    surface: Surface
    texture: str
    tint: tuple[float, float, float] = (1.0, 1.0, 1.0)
    double_sided: bool = False
    shades: bool = True
    place: str = INSIDE


class Pieces(list):
    """A list of pieces with a short way to add one."""

    def add(
        self, surface: Surface, texture: str, tint: tuple[float, float, float] = (1.0, 1.0, 1.0), **settings: object
    ) -> None:
        """Append a Piece; see its fields for the settings."""
        self.append(Piece(surface, texture, tint, **settings))


def merged(pieces: Sequence[Piece], lights: Sequence[NDArray], texture_index: Callable[[str], int]) -> list[Mesh]:
    """Meshes of the pieces, one per (texture, culling, inside or outside, sector of view), with `lights` (n, 3) times tint baked in."""
    groups: dict[tuple, list[tuple[Piece, NDArray]]] = {}
    for piece, light in zip(pieces, lights, strict=True):
        groups.setdefault(
            (piece.texture, piece.double_sided, piece.place == OUTSIDE, _sector(piece.surface)), []
        ).append((piece, light))
    meshes = []
    for key in sorted(groups):
        members = groups[key]
        starts = np.cumsum([0, *(len(piece.surface.positions) for piece, _ in members)])
        meshes.append(
            Mesh(
                f"{key[0]}-{'outside-' if key[2] else ''}{key[3]}",
                np.concatenate([piece.surface.positions for piece, _ in members]),
                np.concatenate([_unit(piece.surface.normals) for piece, _ in members]),
                np.concatenate([piece.surface.uv for piece, _ in members]),
                np.concatenate([light * np.array(piece.tint) for piece, light in members]),
                np.concatenate(
                    [piece.surface.triangles + np.uint32(s) for (piece, _), s in zip(members, starts, strict=False)]
                ),
                texture_index(key[0]),
                key[1],
                albedo=np.concatenate(
                    [np.broadcast_to(piece.tint, piece.surface.positions.shape) for piece, _ in members]
                ),
            )
        )
    return meshes


def _sector(surface: Surface) -> int:
    x, _, z = surface.positions.mean(axis=0)
    return int((np.arctan2(x, -z) / (2 * np.pi) + 0.5) * SECTORS) % SECTORS


def _unit(normals: NDArray) -> NDArray:
    # A pole of a lathe has no gradient; any unit vector will do where a triangle has no area.
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.where(length < 0.5, (0.0, 1.0, 0.0), normals / np.maximum(length, 0.5))


def surface_points(surface: Surface, spacing_m: float, rng: np.random.Generator) -> NDArray[np.float64]:
    """Random points all over the triangles, about one per spacing_m squared, the vertices included."""
    a, b, c = (surface.positions[surface.triangles[:, i]] for i in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    count = np.ceil(area / spacing_m**2).astype(int)
    u, v = np.sqrt(rng.random(count.sum())), rng.random(count.sum())
    a, b, c = (np.repeat(corner, count, axis=0) for corner in (a, b, c))
    points = (1 - u)[:, None] * a + (u * (1 - v))[:, None] * b + (u * v)[:, None] * c
    return np.concatenate([points, surface.positions])
