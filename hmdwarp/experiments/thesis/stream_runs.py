"""Runs whose frames are coded and sent, through the replay itself."""

from __future__ import annotations

from ...link import Bandwidth, LinkOptions, StageTimes
from ...link.codec import EXACT, Coding
from ...report import timeline_svg
from ...run import RunOptions, figures
from .picture_runs import HEADSET
from .run_kinds import RATE_HZ, Figures, StreamRun


def stream(run: StreamRun, scale: float, seconds: float) -> tuple[Figures, str]:
    """Return what the frames of one eye weigh and how late they are, and their time line as SVG.

    scale: of each side of the pictures. Errors: as replay.
    """
    width, height = (max(16, round(side * scale)) for side in run.size)
    summary = figures(
        RunOptions(
            trace=run.trace,
            latency_ms=run.latency_ms,
            warp=run.warp,
            fill="none",
            guard=1.0,
            predict="none",
            lens="none",
            headset=HEADSET,
            size=(width, height),
            rate_hz=RATE_HZ,
            start_s=2.0,
            seconds=seconds,
            coding=Coding(run.codec, depth=EXACT),
            network=LinkOptions() if run.bandwidth_mbit is None else _limited(run.bandwidth_mbit),
            against="",
            metrics_every=10**6,
            workers=0,
        )
    )
    link = summary["link"]
    per_eye = link["mbit_s"] / 2
    found: Figures = {
        "mbit_s": per_eye,
        **{f"{name}_mbit_s": value / 2 for name, value in link["layers_mbit_s"].items()},
    }
    if scale == 1:  # smaller pictures tell nothing of these
        found["full_size_mbit_s"] = per_eye
        # A CPU that renders says nothing of a machine with a GPU.
        found["response_ms"] = (link["response_ms"] or {}).get("median_ms") if summary["clock"] == "gpu" else None
    return found, timeline_svg(link.get("timeline") or ())


def _limited(mbit_s: float) -> LinkOptions:
    """Return a link on which all that a frame goes through delays it."""
    return LinkOptions(bandwidth=Bandwidth(mbit_s), response=StageTimes())
