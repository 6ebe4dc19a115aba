"""Twins of the median fills: NumPy's own median over the covered neighbours."""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from reference._rays import Array


def interpolate(colour: Array, minimum_count: int, size: int = 3) -> Array:
    """(h, w, 4) with coverage in alpha to the same with each empty pixel that has enough covered
    neighbours filled.
    """
    reach = size // 2
    padded = np.pad(colour, ((reach, reach), (reach, reach), (0, 0)))
    windows = sliding_window_view(padded, (size, size), axis=(0, 1)).reshape(*colour.shape, size**2)
    covered = windows[..., 3, :] > 0
    empty = (colour[..., 3] == 0) & (covered.sum(axis=-1) >= minimum_count)
    out = colour.copy()
    for y, x in np.argwhere(empty):
        out[y, x, :3] = np.median(windows[y, x, :3][:, covered[y, x]], axis=1)
        out[y, x, 3] = 1
    return out


def repeated(colour: Array, minimum_count: int, reach: int) -> Array:
    """The same again and again, on the whole picture: `reach` times, or until nothing changes."""
    for _ in range(reach):
        before, colour = colour, interpolate(colour, minimum_count)
        if np.array_equal(before, colour):
            break
    return colour
