"""Pairs of pictures of one type and size: (h, w, 3), RGB, sRGB-encoded, uint8 or floats 0..1."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError

PSNR_CAP_DB = 100.0  # JSON has no infinity; one grey level in one byte of a 640x400 picture would be 107 dB


def check_pair(shown: NDArray[Any], truth: NDArray[Any]) -> None:
    """Raise InputError unless both are (h, w, 3), of one type, uint8 or finite floats in 0..1."""
    if shown.shape != truth.shape or shown.ndim != 3 or shown.shape[2] != 3 or shown.size == 0:
        raise InputError(
            f"cannot compare pictures of shapes {shown.shape} and {truth.shape}: expected two of the same (h, w, 3)"
        )
    if shown.dtype != truth.dtype:
        raise InputError(f"cannot compare a {shown.dtype} picture with a {truth.dtype} one: convert both to uint8 sRGB")
    if shown.dtype == np.uint8:
        return
    # NaN fails both comparisons.
    if shown.dtype.kind != "f" or not all(p.min() >= 0 and p.max() <= 1 for p in (shown, truth)):
        raise InputError(
            f"pictures of {shown.dtype} have values outside 0..1 (or NaN): expected uint8 or sRGB floats in 0..1"
        )


def error_image(shown: NDArray[Any], truth: NDArray[Any]) -> NDArray[np.float32]:
    """Return the signed error shown - truth, (h, w, 3) in -1..1; bytes count as 0..255 over 255."""
    scale = np.float32(255 if shown.dtype == np.uint8 else 1)
    return (shown.astype(np.float32) - truth.astype(np.float32)) / scale


def db_of(mean_square: float) -> float:
    """Return a mean squared error, 0..1, in dB, at most 100 dB."""
    return min(PSNR_CAP_DB, -10 * math.log10(mean_square)) if mean_square else PSNR_CAP_DB
