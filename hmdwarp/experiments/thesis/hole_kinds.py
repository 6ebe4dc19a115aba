"""What the holes of a warped picture are: border, disocclusions, or cracks; and their seams."""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...geometry import View, WarpMap
from ...gpu import flip_rows
from ...metrics import LEAST_STEP, RELATIVE_STEP

Picture = NDArray[Any]


@attrs.frozen(eq=False)
class Holes:
    """Masks (h, w), top row first; together they are all holes."""

    # Beyond the rendered field of view.
    border: NDArray[np.bool_]
    # In front of these surfaces the late frame had another.
    disoccluded: NDArray[np.bool_]
    # The late frame had these surfaces, and no pixel landed here.
    cracks: NDArray[np.bool_]


def holes_of(
    coverage: Picture, truth_inverse_depth: Picture, shown: View, rendered: View, rendered_inverse_depth: Picture
) -> Holes:
    """Tell the kinds of holes apart: where was the true surface of each hole in the late frame?

    coverage, truth_inverse_depth: (h, w), top row first, of the shown view; rendered_inverse_depth:
    (h, w), top row first, of the late frame.
    """
    hole = flip_rows(np.asarray(coverage) == 0)
    there = np.argwhere(hole)
    inverse = np.nan_to_num(flip_rows(np.asarray(truth_inverse_depth, dtype=np.float64)), nan=0.0)[tuple(there.T)]
    frame = flip_rows(np.asarray(rendered_inverse_depth, dtype=np.float64))
    height, width = frame.shape
    mapping = WarpMap.between(shown, (hole.shape[1], hole.shape[0]), rendered, (width, height))
    at, expected, w = mapping.apply(there[:, ::-1] + 0.5, inverse)
    with np.errstate(invalid="ignore"):
        inside = (w > 0) & ((at >= 0) & (at < (width, height))).all(axis=1)
    column, row = np.where(inside[:, None], at, 0).astype(np.intp).T
    seen = frame[row, column]
    same = inside & (np.abs(seen - expected) <= RELATIVE_STEP * expected + LEAST_STEP)
    masks = []
    for chosen in (~inside, inside & ~same, same):
        mask = np.zeros(hole.shape, bool)
        mask[tuple(there[chosen].T)] = True
        masks.append(flip_rows(mask))
    return Holes(*masks)


def seam(shown: Picture, truth: Picture, filled: NDArray[np.bool_], warped: NDArray[np.bool_]) -> float | None:
    """Return the mean false step, 0..1, between filled pixels and the warped ones next to them.

    The step of the picture from one to the other, less that of the truth. shown, truth: (h, w, 3)
    sRGB bytes. None where a filled pixel has no such neighbour.
    """
    error = shown.astype(np.float32) - truth.astype(np.float32)
    total, count = 0.0, 0
    for axis in (0, 1):
        steps = np.abs(np.diff(error, axis=axis)).mean(axis=2)
        ends = [(slice(None),) * axis + (part,) for part in (slice(None, -1), slice(1, None))]
        first, second = ends
        beside = (filled[first] & warped[second]) | (warped[first] & filled[second])
        total += float(steps[beside].sum())
        count += int(beside.sum())
    return total / count / 255 if count else None
