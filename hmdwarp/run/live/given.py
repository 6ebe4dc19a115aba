"""What a live run is asked to do, from options as people write them: on the command line, or in the file of a study."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ...link import LinkOptions
from ...link.codec import Coding
from ...pipeline.options import fill_for, parse_guard, parse_size
from .options import LiveOptions

# Options whose field is called otherwise, for its unit or for what it means.
FIELDS = {
    "latency": "latency_ms",
    "budget": "budget_ms",
    "rate": "rate_hz",
    "horizon": "horizon_ms",
    "reconnect": "reconnect_s",
    "hang": "hang_s",
    "gc_between": "collect",
}


def options_given(
    *,
    warp: str = "forward",
    fill: str | None = None,
    fused: bool = False,
    wide: bool = False,
    size: str | None = None,
    guard: str = "1",
    jitter: str = "",
    delay_trace: Path | None = None,
    loss: str = "",
    bandwidth: str = "",
    link_seed: int = 0,
    codec: str = "none",
    crf: int | None = None,
    bitrate: float | None = None,
    **others: Any,
) -> LiveOptions:
    """LiveOptions from options of `hmdwarp live`, with _ for -. others: those that one field each stands for, by their own names or the
    field's. What is not given is as it is on the command line. Errors: InputError.
    """
    return LiveOptions(
        warp=warp,
        fill=fill_for(warp, fill, fused, wide),
        fused=fused,
        size=None if size is None else parse_size(size),
        guard=parse_guard(guard),
        network=LinkOptions.parse(
            jitter=jitter, delay_trace=delay_trace, loss=loss, bandwidth=bandwidth, seed=link_seed
        ),
        coding=Coding(codec, crf, bitrate),
        **{FIELDS.get(name, name): value for name, value in others.items()},
    )
