"""Pixel centres, a few rows at a time."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

# 32 rows keep float64 temporaries of a 2064x2208 eye under 10 MB, and every matrix product below
# OpenBLAS's threading threshold: with threads its last bits could depend on the load of the
# machine.
_ROWS = 32


def row_blocks(height: int) -> Iterator[slice]:
    """Yield slices of rows that together are 0..height."""
    return (slice(start, min(start + _ROWS, height)) for start in range(0, height, _ROWS))


def pixel_centres(rows: slice, width: int) -> NDArray[np.float64]:
    """Return the pixel coordinates x, y of the centres: (rows, width, 2), bottom row first."""
    x = np.arange(width) + 0.5
    y = np.arange(rows.start, rows.stop) + 0.5
    return np.stack(np.broadcast_arrays(x[None, :], y[:, None]), axis=-1)
