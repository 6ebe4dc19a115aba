"""What a measured run leaves behind: summary.json, frames.csv, pictures and the page."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import attrs

from ..link import medians
from ..metrics import Kept, QualityPool, aggregate
from ..report import FRAME_COLUMNS, SCHEMA, OutputFolder, WorstFrame, comparison_panels, labelled_strip, render_report
from ..version import __version__
from .auto_summary import auto_entry, auto_note
from .log import Row, RunLog
from .rig import Rig

EYES = ("left", "right")
# What a run may write, so that a later run into the same folder removes what it does not write again.
OWNED = ("images/*-left.png", "images/*-right.png", "frames.csv", "report.html", "replay.mp4")


@attrs.frozen(eq=False)
class ReplayResult:
    """What a replay measured. rows: two for each refresh, keyed as frames.csv; summary: as summary.json; against: the same for the
    compared warp, or None."""

    folder: Path
    summary: dict[str, Any]
    rows: list[Row]
    against: dict[str, Any] | None

    @property
    def report(self) -> Path:
        """The page."""
        return self.folder / "report.html"


def outcome_of(rig: Rig, log: RunLog, compared: list[Row] | None, more: dict[str, Any]) -> ReplayResult:
    """The summaries of a run and, if there was one, of the warp that ran beside it. more: what else was measured, by its key."""
    options, rows = rig.options, log.rows
    summary = summary_of(rig, options.warp, options.fill if rig.auto is None else options.warp, options.lens, rows)
    summary["link"] = {**rig.channel.summary(rig.timetable.rate_hz), "response_ms": medians(log.responses)}
    summary |= more
    if rig.auto is not None:
        summary["auto"] = auto_entry(rig.auto, rows)
        summary["notes"] = [*rig.notes, auto_note(summary["auto"], rows)]
    against = None
    if compared is not None:
        against = summary_of(rig, options.against, "none", "none", compared)
        summary["against"] = {key: against[key] for key in ("warp", "fill", "lens", "time_ms", "quality")}
    return ReplayResult(options.out, summary, rows, against)


def summary_of(rig: Rig, warp: str, fill: str, lens: str, rows: list[Row]) -> dict[str, Any]:
    """The keys of summary.json for the named passes on the frames of `rig`; rows as of frames.csv, those of one frame may be several."""
    options = rig.options
    return {
        "schema": SCHEMA,
        "hmdwarp": __version__,
        "trace": rig.track.name or rig.trace.path.stem,
        "scene": rig.scene.name,
        "effects": list(rig.plan.effects),
        "latency_ms": options.latency_ms,
        "warp": warp,
        "fill": fill,
        "lens": lens,
        "headset": rig.headset.name,
        "size": list(rig.size),
        "frames": len({row["frame"] for row in rows}),
        "rate_hz": rig.timetable.rate_hz,
        "guard": options.guard,
        "predict": options.predict,
        "pixels_per_degree": rig.pixels_per_degree,
        "machine": {"gl_renderer": rig.gpu.renderer, "gl_version": rig.gpu.version, "cpu_count": os.cpu_count() or 1},
        "clock": rig.gpu.timer.clock,
        **aggregate(rows),
        "notes": rig.notes,
    }


def write_outcome(
    rig: Rig, out: OutputFolder, log: RunLog, result: ReplayResult, compared: list[Row] | None, pool: QualityPool
) -> None:
    """Everything but the video, which is written while the run goes on."""
    for kept in pool.kept:
        number, eye, _ = kept.key
        out.write_png(f"images/frame-{number:06d}-{EYES[eye]}.png", labelled_strip(_panels_of(kept)))
    out.write_csv("frames.csv", log.frames_csv(), FRAME_COLUMNS)
    page = render_report(
        result.summary,
        result.against,
        rows=result.rows,
        baseline_rows=compared,
        worst=[_worst_frame(result.rows, kept) for kept in pool.worst],
        command=rig.options.command,
        notes=result.summary["notes"],
    )
    out.write_text("report.html", page)
    out.write_json("summary.json", result.summary)


def _panels_of(kept: Kept):
    return comparison_panels(kept.job.rendered_picture, kept.job.now.shown, kept.job.now.truth, kept.result.error_map)


def _worst_frame(rows: list[Row], kept: Kept) -> WorstFrame:
    number, eye, _ = kept.key
    return WorstFrame.of(rows[2 * number]["time_s"], eye, kept)
