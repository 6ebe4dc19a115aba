"""Shapes that are known exactly: as triangles for the server, as formulas for the float64 ray-caster."""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

from .._model import Mesh


@attrs.frozen
class Quad:
    """A parallelogram: centre and two half edges in metres, front where right x up points; light of its four corners.

    corners run (-,-), (+,-), (+,+), (-,+) along (right, up); uv goes 0..repeats over the quad.
    """

    centre: tuple[float, float, float]
    right: tuple[float, float, float]
    up: tuple[float, float, float]
    texture: int = 0
    light: tuple[float, float, float] = (1.0, 1.0, 1.0)
    repeats: tuple[float, float] = (1.0, 1.0)

    @property
    def normal(self) -> NDArray[np.float64]:
        """Unit normal of the front."""
        across = np.cross(self.right, self.up)
        return across / np.linalg.norm(across)

    def mesh(self, name: str) -> Mesh:
        """Two triangles, seen from both sides."""
        signs = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], dtype=np.float64)
        positions = np.array(self.centre) + signs[:, :1] * np.array(self.right) + signs[:, 1:] * np.array(self.up)
        uv = (signs + 1) / 2 * self.repeats
        return Mesh(
            name,
            positions,
            np.tile(self.normal, (4, 1)),
            uv,
            np.tile(self.light, (4, 1)),
            [(0, 1, 2), (0, 2, 3)],
            self.texture,
            double_sided=True,
            albedo=np.tile(self.light, (4, 1)),
        )


@attrs.frozen
class Ball:
    """A sphere: centre and radius in metres, texture around it, `light` from above."""

    centre: tuple[float, float, float]
    radius: float
    texture: int = 0
    colour: tuple[float, float, float] = (1.0, 1.0, 1.0)

    def mesh(self, name: str, rings: int = 48) -> Mesh:
        """Latitude and longitude grid of `rings` x 2 `rings` cells; flat cells lie inside the sphere by at most `sagitta`."""
        theta = np.linspace(0, np.pi, rings + 1)
        phi = np.linspace(0, 2 * np.pi, 2 * rings + 1)
        tt, pp = np.meshgrid(theta, phi, indexing="ij")
        normals = np.stack([np.sin(tt) * np.sin(pp), np.cos(tt), np.sin(tt) * np.cos(pp)], axis=-1).reshape(-1, 3)
        uv = np.stack([pp / (2 * np.pi) * 2, 1 - tt / np.pi], axis=-1).reshape(-1, 2)
        light = np.array(self.colour) * (0.55 + 0.45 * normals[:, 1:2])
        positions = np.array(self.centre) + self.radius * normals
        albedo = np.tile(self.colour, (len(positions), 1))
        return Mesh(
            name, positions, normals, uv, light, grid_triangles(rings + 1, 2 * rings + 1), self.texture, albedo=albedo
        )

    def sagitta(self, rings: int = 48) -> float:
        """How far the flat cells lie inside the sphere at most: half a cell's diagonal angle a gives r (1 - cos a)."""
        half_diagonal = np.hypot(np.pi / rings, np.pi / rings) / 2
        return self.radius * (1 - np.cos(half_diagonal))


def grid_triangles(rows: int, columns: int) -> NDArray[np.uint32]:
    """Triangles of a (rows, columns) grid of vertices, row by row; front where (next column) x (previous row) points."""
    corner = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    down, both, across = corner + columns, corner + columns + 1, corner + 1
    pairs = np.stack([corner, down, both, corner, both, across], axis=1)
    return pairs.reshape(-1, 3).astype(np.uint32)


def checker(
    cells: int, cell_px: int, dark: tuple[int, int, int], bright: tuple[int, int, int], seed: int
) -> NDArray[np.uint8]:
    """A (n, n, 3) checkerboard with a little seeded noise per pixel, so that no two places look alike."""
    index = np.arange(cells * cell_px) // cell_px
    board = ((index[:, None] + index) % 2)[..., None]
    noise = np.random.default_rng(seed).integers(-24, 25, (len(index), len(index), 1))
    return np.clip(np.where(board, bright, dark) + noise, 0, 255).astype(np.uint8)
