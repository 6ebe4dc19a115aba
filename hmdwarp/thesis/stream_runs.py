"""Runs whose frames are coded and sent, through the replay itself."""

from __future__ import annotations

from pathlib import Path

from ..link import Bandwidth, LinkOptions, StageTimes
from ..link.codec import Coding
from ..report import timeline_svg
from ..run import RunOptions, replay
from .picture_runs import HEADSET
from .run_kinds import FULL_SIZE, RATE_HZ, Figures, StreamRun


def stream(run: StreamRun, size: tuple[int, int], seconds: float, folder: Path) -> tuple[Figures, str]:
    """Return what the frames of one eye weigh and how late they are, and their time line as SVG.

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
            network=LinkOptions() if run.bandwidth_mbit is None else _limited(run.bandwidth_mbit),
            against="",
            metrics_every=10**6,
            workers=0,
            images=0,
            out=folder,
            force=True,
        )
    ).summary
    link = summary["link"]
    per_eye = link["mbit_s"] / 2
    figures: Figures = {
        "mbit_s": per_eye,
        **{f"{name}_mbit_s": value / 2 for name, value in link["layers_mbit_s"].items()},
    }
    if (width, height) == run.size:  # what depends on the size has no counterpart in smaller pictures
        figures["full_size_mbit_s"] = per_eye
        figures["response_ms"] = (link["response_ms"] or {}).get("median_ms")
        if run.bandwidth_mbit is not None:
            figures["load_share"] = link["mbit_s"] / run.bandwidth_mbit
    return figures, timeline_svg(link.get("timeline") or ())


def _limited(mbit_s: float) -> LinkOptions:
    """Return a link on which all that a frame goes through delays it."""
    return LinkOptions(bandwidth=Bandwidth(mbit_s), response=StageTimes())
