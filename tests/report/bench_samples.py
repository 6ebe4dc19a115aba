"""A made-up bench in the form of bench.json.

15 warps, two fills, two recordings, three latencies; numbers roughly like real ones.
"""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from typing import Any

import numpy as np

from hmdwarp.metrics import QUALITY

# warp: (ms, FLIP at 200 ms in look-around, share of holes there)
WARPS = {
    "none": (2.1, 0.359, 0.0), "rotation": (2.7, 0.149, 0.02), "planar": (3.5, 0.126, 0.021),
    "environment": (3.9, 0.118, 0.0), "forward_raster": (6.2, 0.121, 0.103), "forward": (7.4, 0.091, 0.103),
    "forward_ordered": (19.0, 0.091, 0.103), "splat": (31.0, 0.079, 0.034), "backward": (4.7, 0.074, 0.032),
    "iterative": (8.8, 0.081, 0.04), "mesh": (160.0, 0.07, 0.031),
    "mesh_adaptive": (21.0, 0.071, 0.031), "multi": (15.3, 0.058, 0.012), "layered": (24.0, 0.049, 0.006),
}  # fmt: skip
INSTANTS = 12
RENDERER = "llvmpipe (LLVM 15.0.6, 256 bits)"
MACHINE = {"gl_renderer": RENDERER, "gl_version": "4.5 (Core Profile) Mesa 22.3.6", "cpu_count": 2}


def _dice(*key: object) -> np.random.Generator:
    return np.random.default_rng(zlib.crc32(repr(key).encode()))


def a_row(
    warp: str = "forward",
    fill: str = "interpolate",
    trace: str = "look-around",
    latency_ms: float = 200.0,
    **changes: Any,
) -> dict[str, Any]:
    """One row of the bench; the same arguments give the same row."""
    ms, flip, holes = WARPS.get(warp.partition(":")[0], (5.0, 0.1, 0.02))
    noise = 1 + 0.03 * _dice(warp, fill, trace, latency_ms).standard_normal(8)
    hard = (latency_ms / 200) ** 0.5 * (1.35 if trace == "walk" else 1.0)
    error = min(0.6, flip * hard * (0.9 if fill == "interpolate" and holes else 1.0) * noise[0])
    holes = min(0.5, holes * hard * (2 if trace == "walk" else 1))
    stages = {"warp": ms * noise[1], "fill": 3.7 * (fill == "interpolate") * noise[2], "effects": 0.0}
    stages["lens"] = 8.3 * noise[3]
    stages["total"] = sum(stages.values())
    quality = {
        **dict.fromkeys(QUALITY, 0.5), "psnr_db": 6 - 21 * np.log10(error), "ssim": 1 - 1.3 * error, "flip": error,
        "hole_share": holes, "border_share": holes / 4, "flicker": error / 7 * noise[4],
    }  # fmt: skip
    shares = {"border_holes": holes / 4, "inside_holes": holes * 3 / 4, "silhouettes": 0.12, "seen": 0.88 - holes}
    parts = {"border_holes": 0.7, "inside_holes": 0.6, "silhouettes": error * 1.9, "seen": error * 0.6}
    # Hard instants are hard for all methods.
    hard_at = {str(60 * n): 1 + 0.1 * np.sin(n) for n in range(INSTANTS)}
    regions = {
        name: {
            "share": share,
            "psnr_db": 30 - 40 * parts[name] if share else None,
            "flip": parts[name] if share else None,
        }
        for name, share in shares.items()
    }
    return {
        **a_run(trace=trace, latency_ms=latency_ms, warp=warp, fill=fill), "size": [1280, 800], "frames": 120,
        "rate_hz": 60.0, "guard": 1.5, "predict": "none", "pixels_per_degree": 12.8,
        "time_ms": {stage: {"median": value, "p95": 1.15 * value} for stage, value in stages.items()},
        "quality": {
            name: {"mean": value, "p95": 1.4 * value, "interval": [0.95 * value, 1.05 * value]}
            for name, value in quality.items()
        },
        "at_instants": {
            name: {at: value * factor for at, factor in hard_at.items()} for name, value in quality.items()
        },
        "measured": dict.fromkeys(quality, 20), "notes": [], "regions": regions, **changes,
    }  # fmt: skip


def a_run(**said: Any) -> dict[str, Any]:
    """What the summary of any run begins with."""
    return {
        "schema": 1, "hmdwarp": "0.1.0", "scene": "room", "effects": [], "lens": "radial", "headset": "rift-dk1",
        "machine": MACHINE, "clock": "wall", **said,
    }  # fmt: skip


def some_rows(
    warps: Sequence[str] = tuple(WARPS),
    fills: Sequence[str] = ("none", "interpolate"),
    traces: Sequence[str] = ("look-around", "walk"),
    latencies: Sequence[float] = (200.0, 400.0, 800.0),
) -> list[dict[str, Any]]:
    """Every combination, as the bench runs them."""
    return [a_row(w, f, t, ms) for t in traces for ms in latencies for w in warps for f in fills]


def a_bench(**changes: Any) -> dict[str, Any]:
    """The whole of bench.json."""
    note = "The GPU timer answers 1 ns for a pass of 4 ms, so the wall clock is used."
    return {
        "schema": 1,
        "hmdwarp": "0.1.0",
        "command": "hmdwarp bench --out out/bench",
        "machine": MACHINE,
        "clock": "wall",
        "clocks": {"wall_ms": 4.18, "gpu_ms": None, "note": note},
        "rows": some_rows(),
        "seconds": 431.5,
        **changes,
    }
