"""Runs the cases of a comparison: one strategy on one recording at one latency each."""

from __future__ import annotations

import platform
from collections.abc import Callable, Sequence
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...client.classes import Client, load_client
from ...report import png_bytes
from ...run.options import RunOptions
from ...run.replay_run import Measured, measured
from ..sweep import KeptCases, Result, SweepCase
from .fitness import client_bytes, decoded_mpx_s, start_bytes, unfit

SHOWN, TRUTH = "shown.png", "truth.png"


@attrs.frozen
class ComparePart:
    """What one case runs."""

    run: RunOptions
    # Whom it may suit: names or files.
    clients: tuple[str, ...]


def pictures_of(kept: KeptCases, case: SweepCase) -> tuple[NDArray, NDArray]:
    """Return what the left eye saw at the first measured instant, and the truth.

    Each is (h, w, 3) sRGB, top row first.
    """
    from PIL import Image

    shown, truth = (np.asarray(Image.open(kept.file(case.identity, name))) for name in (SHOWN, TRUTH))
    return shown, truth


def run_part(case: SweepCase, step: Callable[[float], None]) -> Result:
    """Run one strategy; its pictures are kept beside its row."""
    part: ComparePart = case.what
    result = measured(part.run)
    job = min(result.kept, key=lambda kept: kept.key).job
    pictures = {SHOWN: png_bytes(job.now.shown), TRUTH: png_bytes(job.now.truth)}
    return Result(_row(part.run, result, [load_client(name) for name in part.clients]), pictures)


def _row(run: RunOptions, result: Measured, clients: Sequence[Client]) -> dict[str, Any]:
    """Return one row of compare.json: the keys of summary.json, and what the strategy takes."""
    summary, about = result.summary, (result.plan, result.sizes)
    summary["link"].pop("timeline")
    return {
        **summary,
        "machine": {**summary["machine"], "host": platform.node()},
        "latency_ms": run.total_latency_ms,
        "client_ms": summary["time_ms"]["total"]["median"],
        "server_ms": summary["link"]["response_ms"]["render_ms"] + summary["link"]["response_ms"]["encode_ms"],
        "mbit_s": summary["link"]["mbit_s"],
        "up_mbit_s": summary["link"]["up_mbit_s"],
        "decoded_mpx_s": decoded_mpx_s(summary, *about),
        "start_bytes": start_bytes(summary),
        "client_bytes": client_bytes(summary, *about),
        "unfit": {client.name: unfit(summary, *about, client) for client in clients},
    }
