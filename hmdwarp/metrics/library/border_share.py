"""Holes at the border: the part that no warp could have filled from the frame."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ...geometry import View, WarpMap
from ...gpu import flip_rows
from ..job import Input
from ..metric import Metric, metrics
from ..picture_pairs import pixel_centres, row_blocks


def border_share(
    coverage: NDArray[Any],
    truth_inverse_depth: NDArray[Any],
    shown: View,
    rendered: View,
    rendered_size: tuple[int, int],
) -> float:
    """Return the share of pixels, 0..hole_share, that are holes beyond the rendered field of view.

    The truth says what belongs there. Each hole's pixel and its true inverse depth go through the
    warp map to the rendered view. Beyond the edges of that picture, or beside or behind its eye (w
    <= 0), no frame could have held it. The other holes are disocclusions and gaps between stretched
    pixels.

    coverage, truth_inverse_depth: (h, w), top row first; the latter in 1/m in the shown view, 0 (or
    NaN) = infinitely far. rendered_size: (w, h) of the late frame.
    Errors: InputError if their sizes differ.
    """
    if coverage.shape != truth_inverse_depth.shape or coverage.ndim != 2:
        shapes = f"{coverage.shape} and {truth_inverse_depth.shape}"
        raise InputError(
            f"coverage and the truth's inverse depth have shapes {shapes}: expected two of the same (h, w)"
        )
    holes, inverse_depth = flip_rows(np.asarray(coverage) == 0), flip_rows(np.asarray(truth_inverse_depth))
    height, width = holes.shape
    mapping = WarpMap.between(shown, (width, height), rendered, rendered_size)
    outside = 0
    for rows in row_blocks(height):
        here = holes[rows]
        if not here.any():
            continue
        depth = np.nan_to_num(inverse_depth[rows][here].astype(np.float64), nan=0.0)
        pixel, _, w = mapping.apply(pixel_centres(rows, width)[here], depth)
        inside = (w > 0) & (pixel >= 0).all(axis=-1) & (pixel <= rendered_size).all(axis=-1)
        outside += int(np.count_nonzero(~inside))
    return float(outside / holes.size)


metrics.register(
    Metric(
        name="border_share",
        order=50,
        compute=lambda m: border_share(m.covered, m.truth_inverse_depth, m.now.view, m.rendered, m.rendered_size),
        needs=Input.COVERAGE | Input.DEPTH | Input.RENDERED,
        is_contest=False,
        label="of which outside the rendered frame",
        percent_of="pixels",
        digits=2,
        short_label="border",
        short_digits=1,
        bench_rank=None,
        description="Of these, holes outside the rendered frame, of all pixels",
        explanation="Holes whose surface lay outside the field of view of the late frame. "
        "Only a larger rendered field of view (--guard) helps there, no warp can.",
        study_title="holes at the border",
    )
)
