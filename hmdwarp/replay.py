"""Replays a recorded head trace through the loop and writes what came of it: summary, rows, pictures, page, video."""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from .colour import picture_from_linear
from .gpu.textures import download
from .loop import Refresh
from .measuring import AGAINST, MAIN, Probe
from .metrics import QUALITY
from .metrics.pool import QualityPool
from .metrics.summary import aggregate
from .metrics.worst import Kept
from .options import RunOptions
from .poses import Origin, PoseSample
from .report.files import OutputFolder
from .report.page import WorstFrame, render_report
from .report.pictures import comparison_panels, labelled_strip
from .report.schema import FRAME_COLUMNS, POSE_PARTS, SCHEMA
from .report.video import VideoWriter
from .rig import Rig, build_rig
from .version import __version__

WORST_FRAMES = 6
MOST_WORKERS = 8  # each takes 200 MB; measuring every tenth refresh keeps two busy
EYES = ("left", "right")
OWNED = ("images/*-left.png", "images/*-right.png", "frames.csv", "report.html", "replay.mp4")

Row = dict[str, Any]
Progress = Callable[[int, int], None]


@attrs.frozen(eq=False)
class ReplayResult:
    """What a replay measured. rows are frames.csv's; summary is summary.json's; against the same for the compared warp, or None."""

    folder: Path
    summary: dict[str, Any]
    rows: list[Row]
    against: dict[str, Any] | None

    @property
    def report(self) -> Path:
        """The page."""
        return self.folder / "report.html"


def replay(options: RunOptions, progress: Progress = lambda done, total: None) -> ReplayResult:
    """Run it and write options.out; nothing is left there if it fails or is interrupted.

    progress(done, total) is called after each refresh. Errors: InputError and its kin for what was asked, MachineError for
    what the machine lacks.
    """
    with build_rig(options) as rig, OutputFolder(options.out, owned=OWNED) as out:
        workers = min(os.cpu_count() or 1, MOST_WORKERS) if options.workers is None else options.workers
        with QualityPool(workers, rig.pixels_per_degree, worst=WORST_FRAMES, bucket=lambda key: _contest(rig, key)) as pool:
            probe = Probe(rig, pool, _keep_every(rig))
            rows = _run(rig, probe, out, progress)
        compared = _compared_rows(rig, probe, rows, pool.results)
        _add_quality(rows, pool.results, MAIN)
        result = _result(rig, rows, compared)
        _write(rig, out, result, compared, pool)
    return result


def _run(rig: Rig, probe: Probe, out: OutputFolder, progress: Progress) -> list[Row]:
    rows: list[Row] = []
    times, number = rig.timetable, 0
    with _video(rig, out) as video:
        for instant_ns, shown in times.instants():
            rig.loop.draw(instant_ns)
            refresh = rig.loop.show(instant_ns) if shown else None
            if refresh is not None:
                rows += [_row(rig, number, eye, refresh) for eye in (0, 1)]
                if probe.wants(number):
                    probe.look(number, refresh)
                if video is not None:
                    video.add(_panels(refresh))
                number += 1
            progress(number, times.count)
    return rows


def _video(rig: Rig, out: OutputFolder):
    if not rig.options.video:
        return nullcontext()
    wide, high = rig.size
    return VideoWriter(out.path("replay.mp4"), (2 * wide, high), rig.timetable.rate_hz)


def _panels(refresh: Refresh) -> np.ndarray:
    return np.concatenate([picture_from_linear(download(eye.panel.texture)) for eye in refresh.eyes], axis=1)


def _row(rig: Rig, number: int, eye: int, refresh: Refresh) -> Row:
    turning, moving = _speeds(rig, refresh.shown_ns)
    return {
        "frame": number,
        "eye": eye,
        "time_s": (refresh.shown_ns - rig.track.start_ns) * 1e-9,
        "shown_ns": refresh.shown_ns,
        "drawn_ns": refresh.frame.drawn_ns,
        "age_ms": refresh.age_ns * 1e-6,
        **_pose_columns("pose_origin", "shown", refresh.head),
        **_pose_columns("drawn_origin", "drawn", refresh.frame.head),
        "angular_speed_deg_s": turning,
        "linear_speed_m_s": moving,
        **_stage_columns(rig, refresh.stage_ms[eye]),
    }


def _pose_columns(origin: str, prefix: str, head: PoseSample) -> Row:
    parts = zip(POSE_PARTS, (*head.pose.position_m, *head.pose.orientation_xyzw), strict=True)
    return {origin: Origin(head.origin).name.lower(), **{f"{prefix}_{part}": float(value) for part, value in parts}}


def _stage_columns(rig: Rig, stages: tuple[tuple[str, float], ...]) -> Row:
    """Times by frames.csv's columns; the client's own depth belongs to the warp that asked for it. 0 for a stage not in the plan."""
    columns = dict.fromkeys(("warp_ms", "fill_ms", "effects_ms", "lens_ms"), 0.0)
    for name, milliseconds in stages:
        columns["warp_ms" if name == "client_depth" else f"{name}_ms"] += milliseconds
    return {**columns, "total_ms": sum(columns.values())}


def _speeds(rig: Rig, time_ns: int, half_ns: int = 5_000_000) -> tuple[float, float]:
    """Angular speed in deg/s and linear speed in m/s, by central differences over 10 ms."""
    before, after = rig.track.at(time_ns - half_ns).pose, rig.track.at(time_ns + half_ns).pose
    # Chord to angle: |q0 - q1| = 2 sin(angle / 4) on the unit sphere of quaternions, signs made alike.
    chord = min(
        np.linalg.norm(before.orientation_xyzw - after.orientation_xyzw), np.linalg.norm(before.orientation_xyzw + after.orientation_xyzw)
    )
    turned = 4 * np.arcsin(min(chord / 2, 1.0))
    seconds = 2 * half_ns * 1e-9
    return float(np.degrees(turned) / seconds), float(np.linalg.norm(after.position_m - before.position_m) / seconds)


def _contest(rig: Rig, key: tuple[int, int, int]) -> int | None:
    """One worst picture for each second, of the asked-for warp alone."""
    number, _, which = key
    return int(number / rig.timetable.rate_hz) if which == MAIN else None


def _keep_every(rig: Rig) -> int | None:
    """Every how many refreshes a picture is kept for images/, so that about options.images measured ones are."""
    if not rig.options.images:
        return None
    every = rig.options.metrics_every
    measured = -(-rig.timetable.count // every)
    return every * max(1, -(-measured // rig.options.images))


def _add_quality(rows: list[Row], results: dict, which: int) -> None:
    """In place: ten minutes are 72,000 rows, 100 MB, and need not be there twice."""
    nothing = dict.fromkeys(QUALITY)
    for row in rows:
        row.update(results.get((row["frame"], row["eye"], which), nothing))


def _compared_rows(rig: Rig, probe: Probe, rows: list[Row], results: dict) -> list[Row] | None:
    if not any(key[2] == AGAINST for key in results):
        return None
    timed = [row for row in rows if (row["frame"], row["eye"]) in probe.against_ms]
    timed = [{**row, **_stage_columns(rig, probe.against_ms[row["frame"], row["eye"]])} for row in timed]
    _add_quality(timed, results, AGAINST)
    return timed


def _result(rig: Rig, rows: list[Row], compared: list[Row] | None) -> ReplayResult:
    options = rig.options
    summary = _summary(rig, options.warp, options.fill, options.lens, rows)
    against = None
    if compared is not None:
        against = _summary(rig, options.against, "none", "none", compared)
        summary["against"] = {key: against[key] for key in ("warp", "fill", "lens", "time_ms", "quality")}
    return ReplayResult(rig.options.out, summary, rows, against)


def _summary(rig: Rig, warp: str, fill: str, lens: str, rows: list[Row]) -> dict[str, Any]:
    options = rig.options
    return {
        "schema": SCHEMA,
        "hmdwarp": __version__,
        "trace": rig.track.name or rig.trace.path.stem,
        "scene": rig.scene.name,
        "effects": [effect.name for effect in rig.scene.effects],
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


def _write(rig: Rig, out: OutputFolder, result: ReplayResult, compared: list[Row] | None, pool: QualityPool) -> None:
    for kept in pool.kept:
        number, eye, _ = kept.key
        out.write_png(f"images/frame-{number:06d}-{EYES[eye]}.png", labelled_strip(_panels_of(kept)))
    out.write_csv("frames.csv", result.rows, FRAME_COLUMNS)
    worst = [_worst_frame(rig, result.rows, kept) for kept in pool.worst]
    page = render_report(
        result.summary,
        result.against,
        rows=result.rows,
        baseline_rows=compared,
        worst=worst,
        command=rig.options.command,
        notes=rig.notes,
    )
    out.write_text("report.html", page)
    out.write_json("summary.json", result.summary)


def _panels_of(kept: Kept):
    return comparison_panels(kept.job.late, kept.job.now.shown, kept.job.now.truth, kept.result.error_map)


def _worst_frame(rig: Rig, rows: list[Row], kept: Kept) -> WorstFrame:
    number, eye, _ = kept.key
    time_s = next(row["time_s"] for row in rows if row["frame"] == number)
    return WorstFrame.of(time_s, eye, kept)


__all__ = ["ReplayResult", "replay"]
