"""Colours to put into holes before video encoding."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def covered(colour: NDArray[np.uint8], inverse_depth: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Return the picture with each hole coloured like the covered pixel before it in its row.

    At the start of a row, like the first covered one after it. A black hole would bleed into
    neighbouring pixels, through the codec's blocks and half-resolution chroma, and cost bytes. The
    depth marks the holes; the decoder clears them again. Without holes the picture itself is
    returned.
    """
    hole = inverse_depth < 0
    if not hole.any():
        return colour
    columns = np.where(hole, -1, np.arange(hole.shape[1], dtype=np.int32))
    before = np.maximum.accumulate(columns, axis=1)
    first = np.argmin(hole, axis=1)  # 0 where the whole row is a hole: it stays as it is
    return np.take_along_axis(colour, np.where(before < 0, first[:, None], before)[..., None], axis=1)
