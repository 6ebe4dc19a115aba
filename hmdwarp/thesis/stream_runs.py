"""Runs whose frames are coded and sent, through the replay itself."""

from __future__ import annotations

from pathlib import Path

from ..link.codec import Coding
from ..run import RunOptions, replay
from .picture_runs import HEADSET
from .run_kinds import FULL_SIZE, RATE_HZ, Figures, StreamRun


def stream(run: StreamRun, size: tuple[int, int], seconds: float, folder: Path) -> Figures:
    """Return what the frames of one eye weigh, and the response time by its parts.

    size: of the pictures where the run's is FULL_SIZE. folder: for the results of the replay.
    Errors: as replay.
    """
    width, height = (max(16, round(side * to / full)) for side, to, full in zip(run.size, size, FULL_SIZE, strict=True))
    summary = replay(
        RunOptions(
            trace=run.trace,
            latency_ms=run.latency_ms,
            warp=run.warp,
            fill="none",
            lens="none",
            headset=HEADSET,
            size=(width, height),
            rate_hz=RATE_HZ,
            start_s=2.0,
            seconds=seconds,
            coding=Coding(run.codec),
            against="",
            metrics_every=10**6,
            workers=0,
            images=0,
            out=folder,
            force=True,
        )
    ).summary
    link = summary["link"]
    parts = {f"response_{name}": value for name, value in (link["response_ms"] or {}).items()}
    per_eye = link["mbit_s"] / 2
    full = {"full_size_mbit_s": per_eye} if (width, height) == run.size else {}
    return {"mbit_s": per_eye, **full, **parts}
