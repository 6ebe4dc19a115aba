"""Sharpness: how much of the truth's fine detail a picture still has after resampling."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from .picture_pairs import check_pair


def sharpness(shown: NDArray[Any], truth: NDArray[Any], where: NDArray[Any] | None = None) -> float | None:
    """Return 1 for a picture as sharp as the truth, less where it is blurred, more where sharpened.

    It is the slope of the regression of the picture's fine detail on the truth's, over all pixels
    and channels. Detail is what a 3x3 binomial blur removes. Noise, jagged edges and other detail
    that the truth lacks does not correlate with it and adds nothing (it would, to a ratio of
    energies). Detail in the wrong place is lost detail.

    shown, truth: (h, w, 3), as metrics.picture_pairs. where: (h, w), pixels that count (other than
    0); their neighbours must count too, so that the rim of a hole is not taken for detail. None
    where the truth has no detail. Errors: InputError for sizes that differ.
    """
    check_pair(shown, truth)
    if where is not None and where.shape != shown.shape[:2]:
        raise InputError(f"the mask is {where.shape}, the picture {shown.shape[:2]}: expected the same (h, w)")
    detail, true_detail = _detail(shown), _detail(truth)
    if where is not None:
        inner = _inner(np.asarray(where) != 0)
        detail, true_detail = detail[inner], true_detail[inner]
    energy = float((true_detail * true_detail).sum())
    return float((detail * true_detail).sum()) / energy if energy else None


def _detail(picture: NDArray[Any]) -> NDArray[np.float64]:
    from scipy.ndimage import correlate1d

    values = picture.astype(np.float64)
    blurred = values
    for axis in (0, 1):
        blurred = correlate1d(blurred, [0.25, 0.5, 0.25], axis=axis, mode="nearest")
    return values - blurred


def _inner(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    from scipy.ndimage import binary_erosion

    return binary_erosion(mask, np.ones((3, 3)), border_value=1)
