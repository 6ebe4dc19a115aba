"""What a file's data say of its units and axes: noticed, never applied."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ._notes import Notes
from ._rays import Triangles

Array = NDArray[np.float64]
# Larger than a hall, which is rarely meant in metres; and smaller than a head moves, which goes
# past it or through it.
_LARGE_M, _SMALL_M = 50.0, 0.2
_GROUND_SHARE, _THIN, _LEAST_THICK = 0.3, 0.02, 0.05


def add_hints(triangles: Triangles, low: Array, high: Array, scale: float, up: str, notes: Notes) -> None:
    """Note an extent that is rarely meant in metres, and a ground below the z axis.

    low, high: corners of the scene in metres with +y up. scale, up: as the options have them.
    """
    size = float((high - low).max())
    if scale == 1 and size > _LARGE_M:
        unit, metres = ("a millimetre", 0.001) if size > 1000 else ("a centimetre", 0.01)
        notes.add(f"{size:.3g} m across; if its unit is {unit}, use --scene-scale {metres:g}")
    if scale == 1 and size < _SMALL_M:
        larger = 10 ** round(-np.log10(size))
        notes.add(
            f"{size:.3g} m across, and a head moves farther; --scene-scale {larger:g} makes it {larger * size:.3g} m"
        )
    if up == "y" and _stands_on_z(triangles, low, high):
        notes.add("its ground lies below the z axis, not the y axis; if z is up, use --scene-up z")


def _stands_on_z(triangles: Triangles, low: Array, high: Array) -> bool:
    """Return whether there is a ground at the lowest z and none at the lowest y.

    In a room both have one, and its ceiling is the nearer: then what stands in it must lie low.
    """
    size = high - low
    if size[2] < _LEAST_THICK * size[:2].max():
        return False  # a picture on a wall
    grounds = [_ground_share(triangles, low, high, axis) for axis in (1, 2)]
    if grounds[1] < _GROUND_SHARE:
        return False
    if grounds[0] < _GROUND_SHARE:
        return True
    mass_y, mass_z = (_mass_height(triangles, low, size, axis) for axis in (1, 2))
    return bool(size[2] < 0.75 * min(size[0], size[1]) and mass_z < 0.45 and mass_y >= 0.45)


def _ground_share(triangles: Triangles, low: Array, high: Array, axis: int) -> float:
    """Return the share of the scene's outline, seen along an axis, that a flat ground covers."""
    size = high - low
    across = np.delete(size, axis)
    cross = triangles.crosses
    length = np.linalg.norm(cross, axis=1)
    heights = np.max([triangles.a[:, axis], triangles.b[:, axis], triangles.c[:, axis]], axis=0)
    flat = (np.abs(cross[:, axis]) > 0.95 * length) & (heights <= low[axis] + _THIN * size[axis])
    return float(0.5 * np.abs(cross[flat, axis]).sum() / max(float(across.prod()), 1e-30))


def _mass_height(triangles: Triangles, low: Array, size: Array, axis: int) -> float:
    """Return the mean height of all surfaces, by area, as a share of the scene's."""
    area = np.linalg.norm(triangles.crosses, axis=1)
    middle = (triangles.a[:, axis] + triangles.b[:, axis] + triangles.c[:, axis]) / 3
    return float((area * (middle - low[axis])).sum() / max(float(area.sum() * size[axis]), 1e-30))
