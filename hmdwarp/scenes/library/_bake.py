"""Light and shadow of a room, computed once on the CPU: ambient occlusion, sky through the window, sun, lamps.

Occluders are counted in a grid of small cells; rays add up how full the cells on their way are, which makes soft shadows.
"""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float32]
CELL_M = 0.06


@attrs.frozen
class Opening:
    """The window: an upright rectangle in the plane z = `z_m` through which the daylight comes in."""

    left_m: float
    right_m: float
    bottom_m: float
    top_m: float
    z_m: float

    def points(self, columns: int, rows: int) -> Array:
        """Cell centres of a (columns, rows) split, (n, 3)."""
        x = self.left_m + (np.arange(columns) + 0.5) * (self.right_m - self.left_m) / columns
        y = self.bottom_m + (np.arange(rows) + 0.5) * (self.top_m - self.bottom_m) / rows
        xx, yy = np.meshgrid(x, y)
        return np.stack([xx, yy, np.full_like(xx, self.z_m)], axis=-1).reshape(-1, 3).astype(np.float32)

    def passed_by(self, points: Array, towards: ArrayLike) -> NDArray[np.bool_]:
        """Whether the straight way from each point (n, 3) in direction `towards` goes through the opening."""
        dx, dy, dz = np.asarray(towards, dtype=np.float64)
        t = (self.z_m - points[:, 2]) / dz
        x, y = points[:, 0] + t * dx, points[:, 1] + t * dy
        return (t > 0) & (x > self.left_m) & (x < self.right_m) & (y > self.bottom_m) & (y < self.top_m)


class Occluders:
    """How full each cell of a box in the room is: `all` of it (walls too) for ambient occlusion, `loose` things for shadows."""

    def __init__(self, low: ArrayLike, high: ArrayLike, loose: NDArray, walls: NDArray) -> None:
        from scipy.ndimage import gaussian_filter

        self._low = np.asarray(low, np.float32) - 2 * CELL_M
        self._shape = np.ceil((np.asarray(high) + 2 * CELL_M - self._low) / CELL_M).astype(int)
        full = self._filled(loose)
        self._loose = gaussian_filter(full, 0.6)
        everything = np.maximum(full, self._filled(walls))
        self._near, self._wide = gaussian_filter(everything, 1.5), gaussian_filter(everything, 4.5, truncate=2.5)

    def _index(self, points: NDArray) -> NDArray[np.intp]:
        cell = ((points - self._low) * np.float32(1 / CELL_M)).astype(np.int32)
        cell = np.clip(cell, 0, (self._shape - 1).astype(np.int32))
        return (cell[..., 0] * self._shape[1] + cell[..., 1]) * self._shape[2] + cell[..., 2]

    def _filled(self, points: NDArray) -> Array:
        full = np.zeros(int(np.prod(self._shape)), np.float32)
        full[self._index(points.astype(np.float32))] = 1
        return full.reshape(self._shape)

    def ambient(self, points: Array, normals: Array) -> Array:
        """(n,) openness, 1 on a free plane, less in corners and under things. Walls count, outdoors does not exist."""
        out = np.ones(len(points), np.float32)
        for field, sigma_m, strength in ((self._near, 1.5 * CELL_M, 0.55), (self._wide, 4.5 * CELL_M, 0.75)):
            offset = 1.2 * sigma_m
            found = field.ravel()[self._index(points + normals * np.float32(offset))]
            plane = (
                CELL_M / (sigma_m * np.sqrt(2 * np.pi)) * np.exp(-0.5 * (offset / sigma_m) ** 2)
            )  # what a flat wall alone gives
            out *= 1 - strength * np.clip((found - plane) / (3 * plane), 0, 1)
        return out

    def transit(self, points: Array, normals: Array, lamp: Array, steps: int = 20) -> Array:
        """(n,) share of light from `lamp` (one point, or one per row) that reaches the points past loose things."""
        start = points + normals * np.float32(1.7 * CELL_M)
        way = lamp - start
        loose, thick = self._loose.ravel(), np.zeros(len(points), np.float32)
        for step in range(steps):
            thick += loose[self._index(start + way * np.float32((step + 0.5) / steps))]
        length = np.linalg.norm(way, axis=1) / steps
        return np.exp(-thick * length * np.float32(1 / CELL_M) * 0.9)


def _cosine(normals: Array, way: Array, two_sided: NDArray[np.bool_]) -> Array:
    cosine = np.einsum("ij,ij->i", normals, way)
    return np.where(two_sided, 0.7 * np.abs(cosine) + 0.15, np.maximum(cosine, 0))


@attrs.frozen(eq=False)
class Daylight:
    """Sky and sun behind an opening, in linear RGB; `towards_sun` a unit vector."""

    opening: Opening
    sky: tuple[float, float, float]
    sun: tuple[float, float, float]
    towards_sun: NDArray[np.float64]

    def sky_light(self, room: Occluders, points: Array, normals: Array, two_sided: NDArray[np.bool_]) -> Array:
        """(n, 3) light of the bright opening, an area light sampled at 3 x 2 points."""
        samples = self.opening.points(3, 2)
        area = (self.opening.right_m - self.opening.left_m) * (self.opening.top_m - self.opening.bottom_m)
        total = np.zeros(len(points), np.float32)
        for sample in samples:
            way = sample - points
            squared = np.maximum(np.einsum("ij,ij->i", way, way), 0.15)
            unit = way / np.sqrt(squared)[:, None]
            total += (
                room.transit(points, normals, sample)
                * _cosine(normals, unit, two_sided)
                * np.maximum(-unit[:, 2], 0)
                / squared
            )
        return total[:, None] * np.float32(area / len(samples) / np.pi) * np.array(self.sky, np.float32)

    def sun_light(self, room: Occluders, points: Array, normals: Array, two_sided: NDArray[np.bool_]) -> Array:
        """(n, 3) light of the sun where its way goes through the opening."""
        out = np.zeros((len(points), 3), np.float32)
        lit = np.flatnonzero(self.opening.passed_by(points, self.towards_sun))
        if len(lit):
            towards = self.towards_sun.astype(np.float32)
            distance = (self.opening.z_m - points[lit, 2]) / towards[2]
            share = room.transit(points[lit], normals[lit], points[lit] + distance[:, None] * towards, steps=40)
            cosine = _cosine(normals[lit], np.broadcast_to(towards, (len(lit), 3)), two_sided[lit])
            out[lit] = (share * cosine)[:, None] * np.array(self.sun, np.float32)
        return out


def lamp_light(
    room: Occluders, points: Array, normals: Array, two_sided: NDArray[np.bool_], *, lamp: ArrayLike, colour: ArrayLike
) -> Array:
    """(n, 3) light of a small lamp: `colour` is what a surface 1 m away that faces it gets."""
    lamp = np.asarray(lamp, np.float32)
    way = lamp - points
    squared = np.maximum(np.einsum("ij,ij->i", way, way), 0.12)
    unit = way / np.sqrt(squared)[:, None]
    share = room.transit(points, normals, lamp) * _cosine(normals, unit, two_sided) / squared
    return share[:, None] * np.asarray(colour, np.float32)
