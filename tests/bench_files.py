"""Files as hmdwarp bench writes them, with the figures a test wants; benches without their page."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import patch

from hmdwarp.metrics import QUALITY

PAIRS = (("none", "none"), ("rotation", "none"), ("forward", "interpolate"))
# So far above what any of them takes at 96x80 that another program on this machine cannot make a
# difference.
AMPLE_MS = 1e4
# Its charts take longer than a small bench. For a test, or after `with`.
NO_PAGE = SimpleNamespace(html=lambda: "no page")
WITHOUT_PAGE = patch("hmdwarp.experiments.bench.bench_run.bench_page", lambda *_: NO_PAGE)


def a_row(warp: str, fill: str, total_ms: float | None, flip: float, **changes) -> dict:
    """A row of bench.json for runs of replays.small()."""
    time_ms = {stage: {"median": 0.0, "p95": 0.0} for stage in ("warp", "fill", "effects", "lens")}
    quality = {name: {"mean": 0.0, "p95": 0.0} for name in QUALITY}
    row = {
        "schema": 1, "hmdwarp": "0", "trace": "look-around", "scene": "planes", "effects": [], "latency_ms": 200.0,
        "warp": warp, "fill": fill, "lens": "none", "headset": "flat-90", "size": [96, 80], "frames": 6, "guard": 1.0,
        "machine": {"gl_renderer": "somebody's", "gl_version": "4.5", "cpu_count": 1}, "clock": "wall",
        "time_ms": {**time_ms, "total": {"median": total_ms, "p95": total_ms}},
        "quality": {**quality, "flip": {"mean": flip, "p95": flip}},
    }  # fmt: skip
    return {**row, **changes}


def a_bench(path: Path, rows: list[dict] | None = None, **changes) -> Path:
    """A bench.json in which each of PAIRS takes its share of AMPLE_MS."""
    if rows is None:
        rows = [
            a_row(*pair, AMPLE_MS * share, flip)
            for pair, share, flip in zip(PAIRS, (0.1, 0.3, 0.9), (0.3, 0.2, 0.1), strict=True)
        ]
    path.write_text(json.dumps({"schema": 1, "rows": rows, **changes}), encoding="utf-8")
    return path
