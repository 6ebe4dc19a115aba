"""A picture in a few numbers, to tell whether another machine showed the same."""

from __future__ import annotations

import base64
import math

import numpy as np
from numpy.typing import NDArray

BLOCKS = 8  # on each side of a picture
# Levels of 255 by which the means of two correct drivers may differ. Rounding to a byte is one. A
# sampler with weights of 8 bits is off by 1/256 of what it mixes, on two axes: two levels, if that
# is black and white everywhere. A pixel may show the other side of an edge that passes within
# 1/256 of a pixel of its centre: two levels more, if an edge from black to white crosses each.
BOUND = 5.0
_STEPS = 256


def block_means(picture: NDArray[np.uint8]) -> NDArray[np.float64]:
    """Return the mean levels of BLOCKS x BLOCKS parts of a picture (h, w, 3), each of 3 channels.

    A picture smaller than that has a part for each pixel.
    """
    rows, columns = (np.linspace(0, side, min(BLOCKS, side) + 1).astype(int) for side in picture.shape[:2])
    sums = np.add.reduceat(np.add.reduceat(picture, rows[:-1], axis=0, dtype=np.int64), columns[:-1], axis=1)
    return sums / (np.diff(rows)[:, None, None] * np.diff(columns)[None, :, None])


def blocks_text(blocks: NDArray[np.float64]) -> str:
    """Return the means as text, to 1/256 of a level: base64 of 16-bit numbers, low byte first."""
    return base64.b64encode(np.round(blocks * _STEPS).astype("<u2").tobytes()).decode()


def blocks_apart(first: str, second: str) -> float:
    """Return the largest difference of two pictures' means, in levels; inf for other sizes.

    first, second: as blocks_text. Errors: ValueError for what is none.
    """
    one, other = (np.frombuffer(base64.b64decode(text), "<u2").astype(np.float64) for text in (first, second))
    return float(np.abs(one - other).max(initial=0.0) / _STEPS) if one.shape == other.shape else math.inf
