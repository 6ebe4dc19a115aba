"""PSNR, SSIM and FLIP over all pixels; holes, and flicker."""

from __future__ import annotations

import math
from contextlib import closing
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...base import InputError, in_brief
from ...geometry import real
from ...gpu import Gpu
from ..metric import Input, Metric, metrics
from ..picture_pairs import PSNR_CAP_DB, Alike, PairPass, db_of, pair_of


def ssim(shown: ArrayLike, truth: ArrayLike) -> float:
    """Return the structural similarity: a Gaussian window (sigma 1.5), borders included.

    Source: Wang et al. 2004.

    Parameters
    ----------
    shown, truth : (h, w, 3) array_like
        As psnr; floats count as the nearest byte.

    Returns
    -------
    float
        At most 1, which is identical.

    Raises
    ------
    InputError
        As psnr.
    """
    return _alike(shown, truth, 1.0).ssim


def flip(shown: ArrayLike, truth: ArrayLike, pixels_per_degree: float = 20.0) -> float:
    """Return the mean LDR-FLIP error. Source: Andersson et al. 2020.

    Parameters
    ----------
    shown, truth : (h, w, 3) array_like
        As psnr; floats count as the nearest byte.
    pixels_per_degree : float
        Of the display, 0.1 to 1000: about 20 for a headset, 67 for a monitor.

    Returns
    -------
    float
        From 0 (identical) to 1.

    Raises
    ------
    InputError
        As psnr, and for pixels per degree out of range.
    """
    if not 0.1 <= real(pixels_per_degree) <= 1000:
        raise InputError(f"pixels_per_degree is {in_brief(pixels_per_degree)}: expected 0.1 to 1000, such as 20")
    return float(_alike(shown, truth, real(pixels_per_degree)).flip_map.mean(dtype=float))


def _alike(shown: ArrayLike, truth: ArrayLike, pixels_per_degree: float) -> Alike:
    pair = [one if one.dtype == np.uint8 else np.rint(255 * one).astype(np.uint8) for one in pair_of(shown, truth)]
    with Gpu() as gpu, closing(PairPass(gpu, pair[0].shape[1::-1], pixels_per_degree)) as measuring:
        return measuring.run(*pair)


metrics.register(
    Metric(
        name="ssim",
        order=20,
        compute=lambda m: m.alike.ssim,
        needs=Input.TRUTH | Input.ALIKE,
        of_seen_share=lambda value, share: 1 - (1 - value) / share,
        higher_is_better=True,
        least=-1.0,
        most=1.0,
        label="SSIM",
        bench_rank=2,
        tile_note="higher is better, 1 is identical",
        description="Structural similarity to a picture without latency, 1 is the same",
        explanation="Structural similarity, Gaussian window of 11×11 pixels (σ 1.5), borders included; higher is "
        "better.",
        study_title="structural similarity (SSIM)",
    )
)

metrics.register(
    Metric(
        name="flip",
        order=30,
        most=1.0,
        compute=lambda m: float(m.alike.flip_map.mean(dtype=float)),
        needs=Input.TRUTH | Input.ALIKE,
        label="FLIP",
        bench_rank=float("inf"),
        tile_note="lower is better, 0 is identical",
        chart="FLIP error",
        description="FLIP error against a picture without latency, 0 is the same",
        explanation="How visible the difference is when the two pictures alternate, at the headset's pixels per "
        "degree; 0 is identical.",
        study_title="error (FLIP)",
    )
)


def psnr(shown: ArrayLike, truth: ArrayLike) -> float:
    """Return the peak signal-to-noise ratio over all pixels and channels.

    Parameters
    ----------
    shown, truth : (h, w, 3) array_like
        sRGB, both uint8 or both floats from 0 to 1. The squared error of uint8 is summed in
        integers, so the figure is exact.

    Returns
    -------
    float
        In dB, at most 100 (identical pictures too).

    Raises
    ------
    InputError
        For pictures that cannot be compared.
    """
    shown, truth = pair_of(shown, truth)
    if shown.dtype == np.uint8:
        difference = shown.astype(np.int32) - truth
        mean_square = int(np.sum(difference * difference, dtype=np.int64)) / shown.size / 255**2
    else:
        mean_square = float(np.mean((shown.astype(np.float64) - truth) ** 2))
    return db_of(mean_square)


metrics.register(
    Metric(
        name="psnr_db",
        order=10,
        compute=lambda m: psnr(m.now.shown, m.now.truth),
        of_seen_share=lambda value, share: value + 10 * math.log10(share) if value < PSNR_CAP_DB else value,
        higher_is_better=True,
        label="PSNR",
        unit="dB",
        digits=2,
        short_digits=2,
        bench_rank=5,
        tile_note="higher is better, identical pictures count as 100",
        chart="PSNR",
        chart_from_zero=False,
        description="Peak signal-to-noise ratio against a picture without latency",
        explanation="Squared error in dB; higher is better. Means are means of the dB of single pictures. "
        "A shift by one pixel costs a lot in fine texture.",
        study_title="error (PSNR)",
    )
)


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

metrics.register(
    Metric(
        name="flicker",
        order=60,
        compute=lambda m: m.alike.flicker,  # see PairPass
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
