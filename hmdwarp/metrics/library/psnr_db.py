"""PSNR: peak signal-to-noise ratio of a picture against the truth, over all pixels."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from ..metric import Metric, metrics
from ..picture_pairs import PSNR_CAP_DB, db_of, pair_of


def psnr(shown: ArrayLike, truth: ArrayLike) -> float:
    """Return the ratio in dB over all pixels and channels, at most 100 (identical pictures too).

    Parameters
    ----------
    shown, truth : (h, w, 3) array_like
        sRGB, both uint8 or both floats from 0 to 1. The squared error of uint8 is summed in
        integers, so the figure is exact.

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
