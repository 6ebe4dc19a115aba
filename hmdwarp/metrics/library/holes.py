"""Holes: how much the warp left empty, and what of it no warp could have filled."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..metric import Input, Metric, metrics


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

metrics.register(
    Metric(
        name="border_share",
        order=50,
        most=1.0,
        compute=lambda m: float(m.border_holes.mean()),
        needs=Input.COVERAGE | Input.DEPTH | Input.RENDERED,
        is_contest=False,
        label="of which outside the source field of view",
        percent_of="pixels",
        digits=2,
        short_label="border",
        short_digits=1,
        bench_rank=None,
        description="Of these, holes outside the source field of view, of all pixels",
        explanation="Holes whose surface lay outside the field of view of the late frame. "
        "Only a larger rendered field of view (--guard) helps there, no warp can.",
        study_title="holes at the border",
    )
)
