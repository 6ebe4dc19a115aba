"""Twins of server/foveate.comp and effects/expand.comp: sums over whole blocks, and positions. By
the edges and centres of columns and rows, where the shaders count pixels. Bottom row first."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hmdwarp.geometry import FoveaGrid
from reference._rays import Array

ONE_SURFACE, FLOOR = 0.1, 0.02


def counts(grid: FoveaGrid) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """How many columns each column of the coarser picture holds, and how many rows each row."""
    _, _, *sharp = grid.sharp
    across, up = (
        np.repeat([grid.rim, 1, grid.rim], [before, middle, after])
        for before, middle, after in zip(grid.before, sharp, grid.after, strict=True)
    )
    return across, up


def _sums(values: Array, grid: FoveaGrid, of: np.ufunc = np.add) -> Array:
    across, up = counts(grid)
    rows = of.reduceat(values, np.concatenate([[0], np.cumsum(up)[:-1]]), axis=0)
    return of.reduceat(rows, np.concatenate([[0], np.cumsum(across)[:-1]]), axis=1)


def spread(values: Array, grid: FoveaGrid) -> Array:
    """Each pixel of the coarser picture at all the pixels that it holds."""
    across, up = counts(grid)
    return np.repeat(np.repeat(values, up, axis=0), across, axis=1)


def one_surface(a: Array, b: Array) -> NDArray[np.bool_]:
    return np.abs(a - b) <= ONE_SURFACE * (np.maximum(a, b) + FLOOR)


def foveated(colour: Array, grid: FoveaGrid) -> Array:
    """(h, w, 4) with coverage in alpha: the mean of what is covered."""
    covered = (colour[..., 3:] > 0).astype(float)
    return _sums(colour * covered, grid) / np.maximum(_sums(covered, grid), 1)


def foveated_depth(depth: Array, grid: FoveaGrid) -> Array:
    """(h, w) in 1/m, -1 in holes: the mean over the nearest surface."""
    nearest = _sums(depth, grid, np.maximum)
    same = (depth >= 0) & one_surface(depth, spread(nearest, grid))
    count = _sums(same.astype(float), grid)
    return np.where(count > 0, _sums(np.where(same, depth, 0.0), grid) / np.maximum(count, 1), -1.0)


def _neighbours(held: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
    """The two columns around each pixel's centre, and how far it is from the first to the other."""
    edges = np.concatenate([[0], np.cumsum(held)])
    centres = (edges[:-1] + edges[1:]) / 2
    place = np.interp(np.arange(edges[-1]) + 0.5, centres, np.arange(len(held)))
    low = np.minimum(np.floor(place).astype(int), max(len(held) - 2, 0))
    return low, np.minimum(low + 1, len(held) - 1), place - low


def _mixed(picture: Array, grid: FoveaGrid, counts_for) -> Array:
    (left, right, across), (below, above, up) = (_neighbours(held) for held in counts(grid))
    own, total, weights = spread(picture, grid), 0.0, 0.0
    for rows, down in ((below, 1 - up), (above, up)):
        for columns, aside in ((left, 1 - across), (right, across)):
            there = picture[np.ix_(rows, columns)]
            weight = down[:, None] * aside * counts_for(there, own)
            total = total + (weight[..., None] if there.ndim == 3 else weight) * there
            weights = weights + weight
    weights = np.maximum(weights, 1e-30)
    return total / (weights[..., None] if own.ndim == 3 else weights)


def expanded(colour: Array, grid: FoveaGrid) -> Array:
    """(h, w, 4) on the grid to all pixels: linear in between, without what is not covered."""
    mixed = _mixed(colour, grid, lambda there, own: there[..., 3] > 0)
    own = spread(colour, grid)
    return np.where(own[..., 3:] > 0, mixed, own)


def expanded_depth(depth: Array, grid: FoveaGrid) -> Array:
    """(h, w) on the grid to all pixels: linear in between, without another surface than its own."""
    mixed = _mixed(depth, grid, lambda there, own: (there >= 0) & one_surface(there, own))
    own = spread(depth, grid)
    return np.where(own >= 0, mixed, own)


def sampled(picture: Array, grid: FoveaGrid, place: Array) -> Array:
    """(h, w, 4) at places (.., 2) in pixels of the whole picture: linear between centres."""
    found = []
    for axis, held in enumerate(counts(grid)):
        edges = np.concatenate([[0], np.cumsum(held)])
        found.append(np.interp(place[..., axis], (edges[:-1] + edges[1:]) / 2, np.arange(len(held))))
    low = [np.floor(each).astype(int) for each in found]
    high = [np.minimum(each + 1, len(held) - 1) for each, held in zip(low, counts(grid), strict=True)]
    across, up = ((each - first)[..., None] for each, first in zip(found, low, strict=True))
    below = (1 - across) * picture[low[1], low[0]] + across * picture[low[1], high[0]]
    above = (1 - across) * picture[high[1], low[0]] + across * picture[high[1], high[0]]
    return (1 - up) * below + up * above
