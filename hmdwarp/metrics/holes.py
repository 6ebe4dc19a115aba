"""How much of the picture the warp left empty, and how much of that no warp could have known."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..geometry import View, WarpMap
from .grid import pixel_centres, row_blocks


def hole_share(coverage: NDArray) -> float:
    """Share of pixels, 0..1, with coverage 0. coverage: (h, w), after the warp and before the fill."""
    return float(np.count_nonzero(np.asarray(coverage) == 0)) / np.size(coverage)


def border_share(
    coverage: NDArray,
    truth_inverse_depth: NDArray,
    shown: View,
    rendered: View,
    rendered_size: tuple[int, int],
) -> float:
    """Share of all pixels, 0..hole_share, that are holes and whose true surface lay outside the rendered field of view.

    What is there is known from the truth: each hole's pixel and its true inverse depth go through the warp map to the
    rendered view; beyond the edges of that picture, or beside or behind its eye (w <= 0), no frame could have held it.
    The rest of the holes are disocclusions and gaps between stretched pixels.

    coverage, truth_inverse_depth: (h, w), top row first, the latter in 1/m in the shown view, 0 (or NaN) = infinitely far.
    Errors: InputError if their sizes differ.
    """
    from ..gpu.textures import flip_rows

    if coverage.shape != truth_inverse_depth.shape or coverage.ndim != 2:
        shapes = f"{coverage.shape} and {truth_inverse_depth.shape}"
        raise InputError(f"coverage and the truth's inverse depth have shapes {shapes}: wanted two of the same (h, w)")
    holes = flip_rows(np.asarray(coverage) == 0)
    inverse_depth = np.nan_to_num(flip_rows(np.asarray(truth_inverse_depth, dtype=np.float64)), nan=0.0)
    height, width = holes.shape
    mapping = WarpMap.between(shown, (width, height), rendered, rendered_size)
    outside = 0
    for rows in row_blocks(height):
        if not holes[rows].any():
            continue
        pixel, _, w = mapping.apply(pixel_centres(rows, width), inverse_depth[rows])
        inside = (w > 0) & (pixel >= 0).all(axis=-1) & (pixel <= rendered_size).all(axis=-1)
        outside += np.count_nonzero(holes[rows] & ~inside)
    return float(outside / holes.size)
