"""Colours to put into holes before video encoding."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

T = TypeVar("T", np.uint8, np.uint16)


def covered(colour: NDArray[T], hole: NDArray[np.bool_]) -> NDArray[T]:
    """Return the picture with each hole coloured like the covered pixel before it in its row.

    At the start of a row, like the first covered one after it; a row of holes like the one before
    it, or the first that has any. A black hole would bleed into neighbouring pixels, through the
    codec's blocks and half-resolution chroma, and cost bytes. The decoder clears the holes again.
    Without holes, and with nothing else, the picture itself is returned.
    """
    if not hole.any() or hole.all():
        return colour
    across = np.take_along_axis(colour, _nearest(hole)[..., None], axis=1)
    rows: NDArray = np.all(hole, axis=1)
    return across[_nearest(rows[None])[0]] if rows.any() else across


def _nearest(hole: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Return the column that each pixel of (h, w) takes its colour from; 0 in a row of holes."""
    columns = np.where(hole, -1, np.arange(hole.shape[1], dtype=np.int32))
    before = np.maximum.accumulate(columns, axis=1)
    first = np.argmin(hole, axis=1)
    return np.where(before < 0, first[:, None], before)
