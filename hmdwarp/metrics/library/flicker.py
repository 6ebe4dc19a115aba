"""Flicker: error that changes from frame to frame, which is more visible than constant error."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ...geometry import View, WarpMap
from ...gpu import flip_rows
from ..metric import Input, Metric, metrics
from ..picture_pairs import pixel_centres, row_blocks


def flicker(error: NDArray[Any], view: View, previous_error: NDArray[Any], previous_view: View) -> float | None:
    """Return the mean absolute change, 0..1, of the signed error between neighbouring frames.

    The two are compared at the same shown view direction: the homography of the rotation alone maps
    the previous error to the current view (sampled bilinearly, in float64). Error that is fixed to
    a direction in the world does not count as flicker while the head turns; error that jumps does.
    Pixels whose direction is outside the previous picture, and those that either view hides, are
    left out; None if none remains.
    Interpolation softens the previous error under rotation, so pixel-sharp error counts a little
    even when it is steady.

    error, previous_error: (h, w, 3), top row first, from error_image.
    Errors: InputError if either is not (h, w, 3); the two may differ in size.
    """
    if error.ndim != 3 or previous_error.ndim != 3 or error.shape[2] != previous_error.shape[2]:
        raise InputError(f"error images of shapes {error.shape} and {previous_error.shape}: expected two (h, w, 3)")
    # Channel by channel: NumPy is slow where the last axis is short.
    present, previous = (
        np.ascontiguousarray(np.moveaxis(flip_rows(np.asarray(e)), 2, 0)) for e in (error, previous_error)
    )
    channels, height, width = present.shape
    previous_height, previous_width = previous.shape[1:]
    mapping = WarpMap.between(view, (width, height), previous_view, (previous_width, previous_height))
    total, count = 0.0, 0
    for rows in row_blocks(height):
        centres = pixel_centres(rows, width)
        at, _, _ = mapping.apply(centres, np.zeros(centres.shape[:2]))  # inverse depth 0: the rotation alone
        # An unmoved head must not lose its outermost pixels to the last bits of the homography.
        index = np.stack([at[..., 0].ravel(), at[..., 1].ravel()]) - 0.5
        x, y = np.where(np.abs(index - np.rint(index)) < 1e-9, np.rint(index), index)
        with np.errstate(invalid="ignore"):
            there = (x >= 0) & (x <= previous_width - 1) & (y >= 0) & (y <= previous_height - 1)
        if view.hidden is not None:
            there &= flip_rows(view.seen((width, height)))[rows].ravel()
        both = np.flatnonzero(there)
        if previous_view.hidden is not None:
            before = flip_rows(previous_view.seen((previous_width, previous_height)))
            both = both[before[np.rint(y[both]).astype(int), np.rint(x[both]).astype(int)]]
        left, low = x[both].astype(np.int64), y[both].astype(np.int64)
        beside, above, corner = x[both] - left, y[both] - low, low * previous_width + left
        # On the last column or row the sample is the pixel itself.
        right = corner + (left < previous_width - 1)
        up = np.where(low < previous_height - 1, previous_width, 0)
        for now, before in zip(present, previous, strict=True):
            a, b, c, d = (before.take(at).astype(np.float64) for at in (corner, right, corner + up, right + up))
            lower, upper = a + beside * (b - a), c + beside * (d - c)
            total += float(np.abs(now[rows].take(both) - (lower + above * (upper - lower))).sum())
        count += len(both) * channels
    return float(total / count) if count else None


metrics.register(
    Metric(
        name="flicker",
        order=60,
        compute=lambda m: (
            m.flicker if m.flicker is not None else flicker(m.now.error, m.now.view, m.previous.error, m.previous.view)
        ),
        of_seen_share=lambda value, share: value,  # of the seen pixels already
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
