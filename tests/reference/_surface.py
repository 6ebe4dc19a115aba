"""The surface that a depth picture stands for.

Triangles between pixel centres, cut where surfaces part.
"""

from __future__ import annotations

import itertools

import attrs
import numpy as np
from scipy import ndimage

from reference._rays import FLOAT32_UNIT, Array

STRAIGHT = 0.25  # as shaders/warps/mesh_blocks.comp
MOST = 1e12  # 1/m
# rendered pixels by which pieces of a cut cell reach over its border, as
# shaders/warps/mesh_pieces.vert
OVERLAP = 1 / 64
# Corners of a cell as (row, column), and its edges as pairs of corners.
CORNERS = ((0, 0), (0, 1), (1, 0), (1, 1))
BELOW, ABOVE, LEFT, RIGHT = (0, 1), (2, 3), (0, 2), (1, 3)
HALVES = ((0, 1, 2), (2, 1, 3))


@attrs.frozen(eq=False)
class Surface:
    """n triangles.

    corners (n, 3, 3): x, y in rendered pixels and inverse depth. owner (n, 2): the pixel centre
    whose colour it has, or NaN; towards (n, 2): which way along x, y the colour may change from
    there, 0 for not. doubtful (n,): rounding may have made it, or not.
    """

    corners: Array
    owner: Array
    towards: Array
    doubtful: np.ndarray


@attrs.frozen(eq=False)
class Joins:
    """Which neighbours are one surface.

    along_x (h+2, w+1), along_y (h+1, w+2): of the picture with its border repeated once.
    """

    along_x: np.ndarray
    along_y: np.ndarray


def known_depth(inverse_depth: Array) -> Array:
    """NaN for pixels without depth."""
    known = np.isfinite(inverse_depth) & (inverse_depth >= 0)
    return np.where(known, np.minimum(np.where(known, inverse_depth, 0), MOST), np.nan)


def surface(inverse_depth: Array, steepest: tuple[float, float], *, cut_by_slope: bool) -> Surface:
    """All triangles of a rendered picture, by cells from the bottom left.

    Steepest as in client/warp_kinds/mesh.py.
    """
    depth = known_depth(inverse_depth)
    strict, lenient = (_joins(depth, steepest, cut_by_slope, sign) for sign in (-1, 1))
    padded = np.pad(depth, 1, mode="edge")
    found: list[tuple] = []
    for j, i in itertools.product(range(depth.shape[0] + 1), range(depth.shape[1] + 1)):
        variants = {_edges(joins, j, i) for joins in (strict, lenient)}
        values = tuple(padded[j + y, i + x] for y, x in CORNERS)
        for edges in sorted(variants):
            found += _cell(i, j, values, edges, depth.shape, doubtful=len(variants) > 1)
    if not found:
        return Surface(np.zeros((0, 3, 3)), np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0, bool))
    return Surface(*(np.array(column) for column in zip(*found, strict=True)))


# 1/m: 0.01 of openwarp's clip depth, which goes by 2 from the plane at 0.1 m to that at 20 m, and
# evenly in inverse depth.
GRID_STEP = 0.01 / 2 * (1 / 0.1 - 1 / 20)


def grid_surface(inverse_depth: Array, side: int, ring: float) -> Surface:
    """All triangles of a grid of vertices from border to border, by cells from the bottom left.

    What is nearest around each pixel is a maximum filter of the whole picture.
    """
    depth = np.nan_to_num(known_depth(inverse_depth))
    reach = [int(ring > 0) and max(int(np.floor(ring * n + 0.5)), 1) for n in depth.shape]
    slanted = [int(ring > 0) and max(int(np.floor(2**0.5 * ring * n + 0.5)), 1) for n in depth.shape]
    around = np.zeros([2 * far + 1 for far in np.maximum(reach, slanted)], bool)
    y, x = (n // 2 for n in around.shape)
    for up, right in ((0, 0), (reach[0], 0), (0, reach[1]), slanted):
        around[y + up, x + right] = around[y - up, x - right] = True
    nearest = ndimage.maximum_filter(depth, footprint=around, mode="nearest")
    stepped = np.where(nearest - depth > GRID_STEP, nearest, depth)
    unsure = np.abs(nearest - depth - GRID_STEP) <= 4 * FLOAT32_UNIT * (nearest + GRID_STEP)
    rows, columns = (
        np.searchsorted(np.arange(1, n + 1) * (side - 1), np.arange(side) * n, side="right").clip(max=n - 1)
        for n in depth.shape
    )
    at = np.stack(np.meshgrid(*(np.linspace(0, n, side) for n in depth.shape[::-1])), axis=-1)
    points = np.concatenate([at, stepped[np.ix_(rows, columns)][..., None]], axis=-1)
    doubtful = unsure[np.ix_(rows, columns)]
    cells = [np.s_[y : side - 1 + y, x : side - 1 + x] for y, x in CORNERS]
    of_half = [[cells[k] for k in half] for half in HALVES]
    corners = np.stack([np.stack([points[cell] for cell in half], axis=2) for half in of_half], axis=2)
    count = 2 * (side - 1) ** 2
    owner = np.full((count, 2), np.nan)
    by_half = np.stack([np.logical_or.reduce([doubtful[cell] for cell in half]) for half in of_half], axis=2)
    return Surface(corners.reshape(count, 3, 3), owner, np.ones((count, 2)), by_half.ravel())


def _joins(depth: Array, steepest: tuple[float, float], cut_by_slope: bool, sign: int) -> Joins:
    """With every comparison pushed by its rounding error, one way or the other."""
    wide = np.pad(depth, 2, mode="edge")
    return Joins(
        _joined(wide[1:-1], steepest[0], cut_by_slope, sign),
        _joined(wide[:, 1:-1].T, steepest[1], cut_by_slope, sign).T,
    )


def _joined(rows: Array, limit: float, cut_by_slope: bool, sign: int) -> np.ndarray:
    """For each row's neighbours, without its first and last: whether they are one surface."""
    before, a, b, after = rows[:, :-3], rows[:, 1:-2], rows[:, 2:-1], rows[:, 3:]
    known = ~np.isnan(a) & ~np.isnan(b)
    if not cut_by_slope:
        return known
    push = sign * 4 * FLOAT32_UNIT
    step = np.abs(b - a)
    with np.errstate(invalid="ignore"):
        shallow = step <= limit * np.minimum(a, b) * (1 + push) + push * step
        goes_on = np.abs((b - a) - (a - before)) <= STRAIGHT * step + push * np.fmax(np.maximum(a, b), before)
        went_on = np.abs((after - b) - (b - a)) <= STRAIGHT * step + push * np.fmax(np.maximum(a, b), after)
    equal = (step == 0) if sign < 0 else np.zeros_like(known)  # without rounding there is nothing to doubt
    return known & (shallow | goes_on | went_on | equal)


def _edges(joins: Joins, j: int, i: int) -> tuple[bool, ...]:
    """Below, above, left, right of the cell."""
    return (
        bool(joins.along_x[j, i]),
        bool(joins.along_x[j + 1, i]),
        bool(joins.along_y[j, i]),
        bool(joins.along_y[j, i + 1]),
    )


def _cell(
    i: int, j: int, values: tuple, edges: tuple[bool, ...], shape: tuple[int, int], *, doubtful: bool
) -> list[tuple]:
    """Triangles of the cell between the centres of pixels (i-1, j-1) and (i, j), its part outside
    the picture cut off.
    """
    nowhere = (np.nan, np.nan)

    def place(x: float, y: float) -> tuple[float, float]:
        return min(max(i - 0.5 + x, 0), shape[1]), min(max(j - 0.5 + y, 0), shape[0])

    if all(edges):
        points = [(*place(x, y), value) for (y, x), value in zip(CORNERS, values, strict=True)]
        return [(tuple(points[k] for k in half), nowhere, (1, 1), doubtful) for half in HALVES]
    out = []
    for one, (y, x) in enumerate(CORNERS):
        if np.isnan(values[one]):
            continue
        joined = [pair for pair, edge in zip((BELOW, ABOVE, LEFT, RIGHT), edges, strict=True) if edge]
        beside, over = one ^ 1, one ^ 2
        to_beside, to_over = ((min(one, other), max(one, other)) in joined for other in (beside, over))
        values_at = {
            (x, y): values[one],
            (0.5, y): (values[one] + values[beside]) / 2 if to_beside else values[one],
            (x, 0.5): (values[one] + values[over]) / 2 if to_over else values[one],
            (0.5, 0.5): _middle(one, joined, values),
        }
        points = [(*place(*grown), value) for grown, value in _reaching_out(values_at, x, y)]
        centre = (min(max(i - 1 + x, 0), shape[1] - 1) + 0.5, min(max(j - 1 + y, 0), shape[0] - 1) + 0.5)
        out += [
            (tuple(points[k] for k in half), centre, (to_beside * (1 - 2 * x), to_over * (1 - 2 * y)), doubtful)
            for half in HALVES
        ]
    return out


def _reaching_out(values_at: dict, x: int, y: int) -> list[tuple[tuple[float, float], float]]:
    """Places and values of a quarter in rows from below, its outer sides moved out by OVERLAP on
    the surface they belong to.
    """
    out = []
    for (px, py), value in sorted(values_at.items(), key=lambda item: item[0][::-1]):
        slope_x = (value - values_at[0.5, py]) if px == x else 0.0
        slope_y = (value - values_at[px, 0.5]) if py == y else 0.0
        moved = (px + OVERLAP * (2 * x - 1) * (px == x), py + OVERLAP * (2 * y - 1) * (py == y))
        out.append((moved, max(value + 2 * OVERLAP * (slope_x + slope_y), 0.0)))
    return out


def _middle(one: int, joined: list[tuple[int, int]], values: tuple) -> float:
    """Inverse depth at the middle of the cell on the surface of corner `one`.

    The mean of opposite corners, as far as they belong to it.
    """
    group = {one}
    for _ in range(3):
        group |= {corner for pair in joined if group & set(pair) for corner in pair}
    diagonals = [pair for pair in ((0, 3), (1, 2)) if group.issuperset(pair)]
    chosen = [corner for pair in diagonals for corner in pair] or sorted(group)
    return float(np.mean([values[corner] for corner in chosen]))
