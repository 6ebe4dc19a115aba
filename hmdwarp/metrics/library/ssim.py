"""SSIM: structural similarity of a picture to the truth, over all pixels."""

from ..job import Input
from ..metric import Metric, metrics

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
