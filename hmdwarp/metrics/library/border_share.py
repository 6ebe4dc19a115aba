"""Holes at the border: the part that no warp could have filled from the frame."""

from ..job import Input
from ..metric import Metric, metrics

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
