"""Shapes that are known exactly: triangles for the server, formulas for the float64 ray-caster."""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

from ._mesh import Mesh

Triple = tuple[float, float, float]


@attrs.frozen
class Quad:
    """A parallelogram, front along right x up; corners (-,-), (+,-), (+,+), (-,+) of both."""

    centre: Triple  # metres
    right: Triple  # half edges, metres
    up: Triple
    texture: int = 0
    light: Triple = (1.0, 1.0, 1.0)
    repeats: tuple[float, float] = (1.0, 1.0)  # uv runs from 0 to this over the quad

    @property
    def normal(self) -> NDArray[np.float64]:
        """Unit normal of the front."""
        across = np.cross(self.right, self.up)
        return across / np.linalg.norm(across)

    def mesh(self, name: str) -> Mesh:
        """Return two triangles, seen from both sides."""
        signs = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], dtype=np.float64)
        light = np.tile(self.light, (4, 1))
        return Mesh(
            name,
            np.array(self.centre) + signs[:, :1] * np.array(self.right) + signs[:, 1:] * np.array(self.up),
            np.tile(self.normal, (4, 1)),
            (signs + 1) / 2 * self.repeats,
            light,
            [(0, 1, 2), (0, 2, 3)],
            self.texture,
            double_sided=True,
            albedo=light,
        )


@attrs.frozen
class Ball:
    """A sphere with a texture around it, lit from above."""

    centre: Triple  # metres
    radius: float
    texture: int = 0
    colour: Triple = (1.0, 1.0, 1.0)

    def mesh(self, name: str, rings: int = 48) -> Mesh:
        """Return a grid of `rings` x 2 `rings` cells, with vertices on the sphere."""
        theta = np.linspace(0, np.pi, rings + 1)
        phi = np.linspace(0, 2 * np.pi, 2 * rings + 1)
        tt, pp = np.meshgrid(theta, phi, indexing="ij")
        normals = np.stack([np.sin(tt) * np.sin(pp), np.cos(tt), np.sin(tt) * np.cos(pp)], axis=-1).reshape(-1, 3)
        corner = (np.arange(rings)[:, None] * len(phi) + np.arange(2 * rings)).ravel()
        down, across_down = corner + len(phi), corner + len(phi) + 1
        return Mesh(
            name,
            np.array(self.centre) + self.radius * normals,
            normals,
            np.stack([pp / (2 * np.pi) * 2, 1 - tt / np.pi], axis=-1).reshape(-1, 2),
            np.array(self.colour) * (0.55 + 0.45 * normals[:, 1:2]),
            np.stack([corner, down, across_down, corner, across_down, corner + 1], axis=1).reshape(-1, 3),
            self.texture,
            albedo=np.tile(self.colour, (len(normals), 1)),
        )


def checker(
    cells: int, cell_px: int, dark: tuple[int, int, int], bright: tuple[int, int, int], seed: int
) -> NDArray[np.uint8]:
    """Return a (n, n, 3) checkerboard with seeded noise, so that no two places look alike."""
    index = np.arange(cells * cell_px) // cell_px
    board = ((index[:, None] + index) % 2)[..., None]
    noise = np.random.default_rng(seed).integers(-24, 25, (len(index), len(index), 1))
    return np.clip(np.where(board, bright, dark) + noise, 0, 255).astype(np.uint8)
