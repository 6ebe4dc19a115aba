"""The memory traffic of a pass, the least time that takes on this device, and the pass's time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...client.plan import Plan
from ...frames.layers import PIXEL_BYTES


def passes_of(
    plan: Plan, rendered_pixels: int, shown_pixels: int, stages: Mapping[str, Sequence[float]], bytes_per_s: float
) -> list[dict[str, Any]]:
    """Return the `passes` of a row: name, bytes, bound_ms, median_ms, times_bound.

    bound_ms: the bytes at the copy bandwidth. stages: the timer's milliseconds by stage. The bound
    counts each byte once and no arithmetic, so no pass can be quicker unless its pictures stay in
    the caches. Drawing the client's own depth is a pass of its own here; of it, only the picture it
    writes counts.
    """
    moved = {"client_depth": PIXEL_BYTES["r32f"] * shown_pixels} if plan.draws_client_depth else {}
    moved["warp"] = plan.warp.bytes_moved(rendered_pixels, shown_pixels, plan.choice.settings)
    if plan.fills:
        moved["fill"] = sum(fill.entry.bytes_moved(shown_pixels) for fill in plan.fills)
    if plan.effect_passes:
        moved["effects"] = sum(one.made_by.bytes_moved(rendered_pixels, shown_pixels) for one in plan.effect_passes)
    if plan.lens.is_pass and not plan.fused:
        moved["lens"] = plan.lens.bytes_moved(shown_pixels)
    return [_pass(name, count, stages[name], bytes_per_s) for name, count in moved.items() if stages.get(name)]


def _pass(name: str, count: int, milliseconds: Sequence[float], bytes_per_s: float) -> dict[str, Any]:
    bound_ms, median_ms = count / bytes_per_s * 1e3, float(np.median(milliseconds))
    return {
        "name": name,
        "bytes": int(count),
        "bound_ms": bound_ms,
        "median_ms": median_ms,
        "times_bound": median_ms / bound_ms,
    }
