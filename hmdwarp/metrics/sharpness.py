"""How much of the truth's fine detail a picture still has: what resampling twice costs against resampling once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from .image import check_pair


def sharpness(shown: NDArray, truth: NDArray, where: NDArray | None = None) -> float | None:
    """1 where the picture is as sharp as the truth, below 1 where it is blurred, above where it is sharpened.

    The slope of the regression of the picture's fine detail on the truth's, over all pixels and channels. Detail is what a 3x3
    binomial blur takes away. Noise, jagged edges and other detail that the truth does not have does not correlate with it and so adds
    nothing (it would, to a ratio of energies); detail in the wrong place is lost detail.

    shown, truth: (h, w, 3), as metrics.image. where: (h, w), pixels that count (others than 0); their neighbours must count too, so
    that the rim of a hole is not taken for detail. None where the truth has no detail. Errors: InputError for sizes that differ.
    """
    check_pair(shown, truth)
    if where is not None and where.shape != shown.shape[:2]:
        raise InputError(f"the mask is {where.shape}, the picture {shown.shape[:2]}: wanted the same (h, w)")
    found, wanted = _detail(shown), _detail(truth)
    if where is not None:
        inner = _inner(np.asarray(where) != 0)
        found, wanted = found[inner], wanted[inner]
    energy = float((wanted * wanted).sum())
    return float((found * wanted).sum()) / energy if energy else None


def _detail(picture: NDArray) -> NDArray[np.float64]:
    from scipy.ndimage import correlate1d

    values = picture.astype(np.float64)
    blurred = values
    for axis in (0, 1):
        blurred = correlate1d(blurred, [0.25, 0.5, 0.25], axis=axis, mode="nearest")
    return values - blurred


def _inner(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    from scipy.ndimage import binary_erosion

    return binary_erosion(mask, np.ones((3, 3)), border_value=1)
