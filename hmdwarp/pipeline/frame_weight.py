"""What frames weigh that carry what plans read, and how many there are at a time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..client.plan import Plan, needs_of
from ..frames import frame_bytes
from ..headsets import Headset
from ..options import DEFAULT_GUARD
from .link_times import frames_held
from .options import PipelineOptions
from .sizes import eye_sizes, rendered_entry

# 3 on each axis: of a field of view of 90 degrees that makes 143, and a planar picture of more is
# mostly border.
MOST_GUARD_PIXELS = 9


def frame_weight(options: PipelineOptions, headset: Headset, plans: Sequence[Plan]) -> dict[str, Any]:
    """Return eyes, sizes, bytes of each layer and of a frame, and how many frames there are."""
    rate_hz = options.rate_hz or headset.refresh_hz
    needs, sizes = needs_of(plans), eye_sizes(options.guard_band, headset, options.size or headset.eye_size_px)
    pictures = options.source_kind.eyes
    layers = frame_bytes(needs, sizes, {name for plan in plans for name in plan.layers}, eyes=pictures)
    return {
        "eyes": pictures,
        **rendered_entry(options.guard_band, sizes),
        "layers": layers,
        "bytes": sum(layers.values()),
        "at_once": frames_held(options, rate_hz, needs),
        "latency_ms": options.latency_ms,
        "rate_hz": rate_hz,
    }


def guard_notes(options: PipelineOptions, weight: dict[str, Any]) -> list[str]:
    """Return a note on a guard band that is larger than head motion ever calls for."""
    if weight["pixels"] <= MOST_GUARD_PIXELS:
        return []
    band = f"{options.guard_band} draws {weight['pixels']:.0f} times the pixels"
    return [
        f"{band}: --guard is a factor of the field of view in tangents, not degrees; the default is {DEFAULT_GUARD:g}"
    ]
