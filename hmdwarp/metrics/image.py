"""Error of one picture against the truth: PSNR, SSIM and FLIP, over all pixels.

Pictures are (h, w, 3), RGB, sRGB-encoded, uint8 or floats 0..1; both the same type and size.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError

PSNR_CAP_DB = 100.0  # JSON has no infinity; one grey level in one byte of a 640x400 picture would be 107 dB

SSIM_SIGMA = 1.5
SSIM_WINDOW = 11


def check_pair(shown: NDArray, truth: NDArray) -> None:
    """Errors: InputError unless both are (h, w, 3), of one size and one type, uint8 or finite floats within 0..1."""
    if shown.shape != truth.shape or shown.ndim != 3 or shown.shape[2] != 3 or shown.size == 0:
        raise InputError(
            f"cannot compare pictures of shapes {shown.shape} and {truth.shape}: wanted two of the same (h, w, 3)"
        )
    if shown.dtype != truth.dtype:
        raise InputError(f"cannot compare a {shown.dtype} picture with a {truth.dtype} one: convert both to uint8 sRGB")
    if shown.dtype == np.uint8:
        return
    if shown.dtype.kind != "f" or not all(
        p.min() >= 0 and p.max() <= 1 for p in (shown, truth)
    ):  # NaN fails both comparisons
        raise InputError(
            f"pictures of {shown.dtype} have values outside 0..1 (or NaN): wanted uint8 or sRGB floats within 0..1"
        )


def psnr_db(shown: NDArray, truth: NDArray) -> float:
    """Peak signal-to-noise ratio in dB over all pixels and channels, at most 100 dB (identical pictures too).

    For uint8 the squared error is summed in integers, so the figure is exact and depends on no summation order.
    """
    check_pair(shown, truth)
    if shown.dtype == np.uint8:
        difference = shown.astype(np.int32) - truth
        mean_square = int(np.sum(difference * difference, dtype=np.int64)) / shown.size / 255**2
    else:
        mean_square = float(np.mean((shown.astype(np.float64) - truth) ** 2))
    if mean_square == 0:
        return PSNR_CAP_DB
    return min(PSNR_CAP_DB, -10 * math.log10(mean_square))


def ssim(shown: NDArray, truth: NDArray) -> float:
    """Mean structural similarity, at most 1, over all pixels and the three channels.

    Window: Gaussian of sigma 1.5 pixels, 11x11, population covariance, as in the paper. The mean takes in the border
    (mirrored), which scikit-image leaves out: the border is where late pictures have their holes.
    Source: Wang, Bovik, Sheikh, Simoncelli 2004, Image quality assessment, eq. 13; scikit-image's implementation.
    """
    from skimage.metrics import structural_similarity

    check_pair(shown, truth)
    if shown.dtype != np.uint8:
        shown, truth = shown.astype(np.float64), truth.astype(np.float64)
    # win_size only decides whether scikit-image accepts pictures smaller than the window; the Gaussian is set by sigma.
    smallest = min(shown.shape[:2])
    _, similarity = structural_similarity(
        shown,
        truth,
        channel_axis=2,
        data_range=255 if shown.dtype == np.uint8 else 1.0,
        gaussian_weights=True,
        sigma=SSIM_SIGMA,
        use_sample_covariance=False,
        win_size=min(SSIM_WINDOW, smallest - (smallest + 1) % 2),
        full=True,
    )
    return float(similarity.mean())


def flip(shown: NDArray, truth: NDArray, pixels_per_degree: float) -> tuple[float, NDArray[np.float32]]:
    """Mean LDR-FLIP error 0..1 and its (h, w) map: how visible the difference is when the two pictures alternate.

    pixels_per_degree: of the display the picture is made for (20 to 25 for a headset; flip-evaluator's own default of
    67, a desktop screen, would blur fine error away). Errors: InputError if it is not positive.
    Source: Andersson et al. 2020, FLIP: A Difference Evaluator for Alternating Images; flip-evaluator's implementation,
    which takes RGB in this order and, with inputsRGB=True, sRGB-encoded values.
    """
    from flip_evaluator import evaluate

    check_pair(shown, truth)
    if not (pixels_per_degree > 0 and math.isfinite(pixels_per_degree)):
        raise InputError(f"{pixels_per_degree} pixels per degree: wanted a positive number, the headset's")
    scale = np.float32(255 if shown.dtype == np.uint8 else 1)
    reference, test = (np.ascontiguousarray(p, dtype=np.float32) / scale for p in (truth, shown))
    parameters = {"ppd": float(pixels_per_degree)}
    error, _, _ = evaluate(
        reference, test, "LDR", inputsRGB=True, applyMagma=False, computeMeanError=False, parameters=parameters
    )
    error = error[..., 0]
    return float(error.mean(dtype=np.float64)), error
