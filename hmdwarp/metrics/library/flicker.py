"""Flicker: error that changes from frame to frame, which is more visible than constant error."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ...geometry import View, WarpMap
from ...gpu import flip_rows
from ..grid import pixel_centres, row_blocks
from ..metric import Metric, metrics
from ..metric_inputs import Input


def flicker(error: NDArray, view: View, previous_error: NDArray, previous_view: View) -> float | None:
    """Return the mean absolute change, 0..1, of the signed error between neighbouring frames.

    The two are compared at the same shown view direction: the homography of the rotation alone maps
    the previous error to the current view (sampled bilinearly, in float64). Error that is fixed to
    a direction in the world does not count as flicker while the head turns; error that jumps does.
    Pixels whose direction is outside the previous picture are left out; None if none remains.
    Interpolation softens the previous error under rotation, so pixel-sharp error counts a little
    even when it is steady.

    error, previous_error: (h, w, 3), top row first, from error_image.
    Errors: InputError if either is not (h, w, 3); the two may differ in size.
    """
    from scipy.ndimage import map_coordinates

    if error.ndim != 3 or previous_error.ndim != 3 or error.shape[2] != previous_error.shape[2]:
        raise InputError(f"error images of shapes {error.shape} and {previous_error.shape}: expected two (h, w, 3)")
    present, previous = flip_rows(np.asarray(error)), flip_rows(np.asarray(previous_error, dtype=np.float64))
    height, width = present.shape[:2]
    previous_height, previous_width = previous.shape[:2]
    mapping = WarpMap.between(view, (width, height), previous_view, (previous_width, previous_height))
    last = np.array([previous_width - 1, previous_height - 1], dtype=np.float64)
    total, count = 0.0, 0
    for rows in row_blocks(height):
        centres = pixel_centres(rows, width)
        at, _, _ = mapping.apply(centres, np.zeros(centres.shape[:2]))  # inverse depth 0: the rotation alone
        index = at - 0.5
        # An unmoved head must not lose its outermost pixels to the last bits of the homography.
        index = np.where(np.abs(index - np.rint(index)) < 1e-9, np.rint(index), index)
        with np.errstate(invalid="ignore"):
            both = ((index >= 0) & (index <= last)).all(axis=-1)
        where = index[both].T[::-1]  # map_coordinates takes row, column
        for channel in range(present.shape[2]):
            before = map_coordinates(previous[..., channel], where, order=1, mode="nearest")
            total += float(np.abs(present[rows][..., channel][both] - before).sum())
        count += both.sum() * present.shape[2]
    return float(total / count) if count else None


metrics.register(
    Metric(
        name="flicker",
        order=60,
        compute=lambda m: flicker(m.now.error, m.now.view, m.previous.error, m.previous.view),
        needs=Input.TRUTH | Input.PREVIOUS,
        label="Flicker",
        short_label="flicker",
        bench_rank=4,
        chart="Flicker",
        description="Change of the error from one picture to the next",
        explanation="Mean change of the error from one frame to the next in the same direction of view. "
        "Error that stays where it is in the world counts little; error that jumps counts in full.",
        study_title="flicker",
    )
)
