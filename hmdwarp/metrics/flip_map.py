"""FLIP: how visible the difference between a picture and the truth is when the two alternate."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from .picture_pairs import check_pair


def flip(shown: NDArray[Any], truth: NDArray[Any], pixels_per_degree: float) -> tuple[float, NDArray[np.float32]]:
    """Return the mean LDR-FLIP error, 0..1, and its (h, w) map.

    shown, truth: (h, w, 3), as metrics.picture_pairs. pixels_per_degree: of the display that shows
    the picture, 20 to 25 for a headset. flip-evaluator's own default of 67, a desktop screen, would
    blur fine error away.
    Errors: InputError if it is not positive, and for pictures that cannot be compared.
    Source: Andersson et al. 2020, FLIP: A Difference Evaluator for Alternating Images;
    flip-evaluator's implementation, which takes RGB in this order and, with inputsRGB=True,
    sRGB-encoded values.
    """
    from flip_evaluator import evaluate

    check_pair(shown, truth)
    if not (pixels_per_degree > 0 and math.isfinite(pixels_per_degree)):
        raise InputError(f"{pixels_per_degree} pixels per degree: expected a positive number, the headset's")
    scale = np.float32(255 if shown.dtype == np.uint8 else 1)
    reference, test = (np.ascontiguousarray(p, dtype=np.float32) / scale for p in (truth, shown))
    parameters = {"ppd": float(pixels_per_degree)}
    error, _, _ = evaluate(
        reference, test, "LDR", inputsRGB=True, applyMagma=False, computeMeanError=False, parameters=parameters
    )
    error = error[..., 0]
    return float(error.mean(dtype=np.float64)), error
