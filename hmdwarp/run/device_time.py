"""A model of what passes take on a device that is not here."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path

from ..client.classes import Client
from ..client.plan import PANEL, SHOWN, SHOWN_DEPTH, Plan
from ..frames import EyeSizes, frame_bytes

_MEASURED = tomllib.loads(Path(__file__).with_name("measured_passes.toml").read_text(encoding="utf-8"))
MODEL = (
    f"The least is by the bytes that it moves and the makers' memory rate, the most by passes measured on an "
    f"{_MEASURED['gpu']['name']}. Measure the device itself: 'hmdwarp serve --web', with &bench in the page's address."
)
_PIXEL_BYTES = {SHOWN: 8, PANEL: 8, SHOWN_DEPTH: 4}


def device_ms(plan: Plan, size: tuple[int, int], client: Client) -> tuple[float, float, float]:
    """Return the least ms, the geometric mean of both ends, and the most, of one eye of (w, h).

    Least: what the passes read and write crosses the memory once, at its maker's rate. Most: as on
    the measured GPU, times how much slower the device's memory or arithmetic is, the worse of both;
    a pass that was not measured counts as the slowest that was, a lens as a warp that only copies.
    """
    pixels, gpu, layers = math.prod(size), _MEASURED["gpu"], set(plan.layers)
    frame = sum(frame_bytes(plan.needs, EyeSizes(size, size), layers, eyes=1).values())
    names = [name for step in plan.steps for name in (*step.reads, *step.writes)]
    moved = (1 + plan.needs.others.past) * frame + pixels * sum(_PIXEL_BYTES.get(name, 0) for name in names)
    least = moved / client.memory_gb_s * 1e-6
    passes = [("warps", plan.warp.name), *(("fills", fill.entry.name) for fill in plan.fills)]
    passes += [("warps", "none")] if plan.lens.is_pass else []
    there = sum(_MEASURED[kind].get(name, max(_MEASURED[kind].values())) for kind, name in passes)
    slower = max(gpu["memory_gb_s"] / client.memory_gb_s, gpu["compute_tflops"] / client.compute_tflops)
    most = max(least, there * slower * pixels / math.prod(gpu["size"]))
    return least, math.sqrt(least * most), most
