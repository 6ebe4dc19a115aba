"""Depth as the camera gave it."""

from __future__ import annotations

from . import MeasuredDepth, Pixels, Repair, repairs


@repairs.register
class NoRepair(Repair):
    """Leave depth as it is: missing depth is a hole."""

    name = "none"
    summary = "depth as it was given: a pixel without depth is a hole"
    needs = "nothing"
    source = "the baseline of every repair"
    is_pass = False

    def run(self, colour: Pixels, depth: MeasuredDepth) -> MeasuredDepth:
        return depth
