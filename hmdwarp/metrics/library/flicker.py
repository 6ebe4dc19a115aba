"""Flicker: error that changes from frame to frame, which is more visible than constant error."""

from __future__ import annotations

from ..metric import Input, Metric, metrics

metrics.register(
    Metric(
        name="flicker",
        order=60,
        compute=lambda m: m.flicker,  # see PairPass
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
