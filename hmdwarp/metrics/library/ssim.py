"""SSIM: structural similarity of a picture to the truth, over all pixels."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..metric import Metric, metrics
from ..picture_pairs import check_pair

SSIM_SIGMA = 1.5
SSIM_WINDOW = 11


def ssim(shown: NDArray[Any], truth: NDArray[Any]) -> float:
    """Return the mean structural similarity, at most 1, over all pixels and the three channels.

    shown, truth: (h, w, 3), as metrics.picture_pairs.
    Window: Gaussian of sigma 1.5 pixels, 11x11, population covariance, as in the paper. The mean
    includes the border (mirrored), which scikit-image leaves out: the border is where late pictures
    have their holes.
    Errors: InputError for pictures that cannot be compared.
    Source: Wang, Bovik, Sheikh, Simoncelli 2004, Image quality assessment, eq. 13; scikit-image's
    implementation.
    """
    from skimage.metrics import structural_similarity

    check_pair(shown, truth)
    if shown.dtype != np.uint8:
        shown, truth = shown.astype(np.float64), truth.astype(np.float64)
    # win_size only decides whether scikit-image accepts pictures smaller than the window: sigma
    # sets the Gaussian.
    smallest = min(shown.shape[:2])
    compare: Any = structural_similarity  # has no annotations
    _, similarity = compare(
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


metrics.register(
    Metric(
        name="ssim",
        order=20,
        compute=lambda m: ssim(m.now.shown, m.now.truth),
        higher_is_better=True,
        label="SSIM",
        bench_rank=2,
        tile_note="higher is better, 1 is identical",
        description="Structural similarity to a picture without latency, 1 is the same",
        explanation="Structural similarity, Gaussian window of 11×11 pixels (σ 1.5), borders included; higher is "
        "better.",
        study_title="likeness (SSIM)",
    )
)
