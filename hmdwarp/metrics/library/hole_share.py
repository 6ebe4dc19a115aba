"""Holes: how much of the picture the warp left empty."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..job import Input
from ..metric import Metric, metrics


def hole_share(coverage: NDArray[Any]) -> float:
    """Return the share of pixels, 0..1, with coverage 0.

    coverage: (h, w), after the warp and before the fill.
    """
    return float(np.count_nonzero(np.asarray(coverage) == 0)) / np.size(coverage)


metrics.register(
    Metric(
        name="hole_share",
        order=40,
        most=1.0,
        compute=lambda m: hole_share(m.covered),
        needs=Input.COVERAGE,
        is_contest=False,
        label="Holes",
        percent_of="pixels",
        digits=2,
        short_label="holes",
        short_digits=1,
        bench_rank=6,
        tile_note="empty after the warp, before the fill",
        chart="Holes before the fill",
        description="Pixels without anything after the warp and before the fill, of all",
        explanation="Pixels that the warp left empty, before the fill.",
        study_title="holes",
    )
)
