"""Holes at the border: the part that no warp could have filled from the frame."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...geometry import View
from ..job import Input, border_holes
from ..metric import Metric, metrics


def border_share(
    coverage: NDArray[Any],
    truth_inverse_depth: NDArray[Any],
    shown: View,
    rendered: View,
    rendered_size: tuple[int, int],
) -> float:
    """Return the share of pixels, 0..hole_share, that are border_holes; arguments as there."""
    beyond = border_holes(coverage, truth_inverse_depth, shown, rendered, rendered_size)
    return float(np.count_nonzero(beyond) / beyond.size)


metrics.register(
    Metric(
        name="border_share",
        order=50,
        most=1.0,
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
