"""FLIP, the mean of its map; see flip_map."""

from ..job import Input
from ..metric import Metric, metrics

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
