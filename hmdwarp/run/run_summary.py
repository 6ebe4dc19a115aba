"""Rows of frames.csv, keys of summary.json that runs share, and the files of a replay."""

from __future__ import annotations

import csv
import io
import os
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from ..base import __version__, made_with
from ..geometry import Pose
from ..gpu import Gpu
from ..link import ResponseTime, TransitStats, figures_of_parts
from ..metrics import QUALITY, Kept, QualityPool, aggregate, difference, metrics_in_order
from ..pipeline import Refresh
from ..pipeline.sizes import rendered_entry
from ..poses import PoseTrack, quaternions
from ..poses.assumptions import Assumption, assumption_rows
from ..report import (
    DIFF_PAGE,
    FRAME_COLUMNS,
    POSE_PARTS,
    SCHEMA,
    OutputFolder,
    Panel,
    StoredRun,
    WorstFrame,
    columns_of,
    digests,
    in_a_row,
    labelled_strip,
    render_report,
    summary_html,
)
from ..scenes import InputEvent
from .requirements import Verdict
from .run import ReplayRun, Run

_HALF_NS = 5_000_000
_APART_NS = 500_000_000  # after a longer break the speed between two pictures is meaningless
Speeds = tuple[float | None, float | None]


def _speeds(before: Pose, after: Pose, seconds: float) -> Speeds:
    """Return angular speed in deg/s and linear speed in m/s."""
    turned = quaternions.angle_between(before.orientation_xyzw, after.orientation_xyzw)
    return float(np.degrees(turned) / seconds), float(np.linalg.norm(after.position_m - before.position_m) / seconds)


def speeds_between(before: Refresh | None, now: Refresh) -> Speeds:
    """Return both speeds between two pictures; None for the first picture and after a break."""
    if before is None or not 0 < now.shown_ns - before.shown_ns <= _APART_NS:
        return None, None
    return _speeds(before.head.pose, now.head.pose, (now.shown_ns - before.shown_ns) * 1e-9)


MOST_FRAMES = 12


class Timeline:
    """Keep how the last MOST_FRAMES frames that were shown came there, and when they were seen."""

    def __init__(self) -> None:
        # How each came, and the first and the last instant when it was seen.
        self._kept: deque[tuple[TransitStats, int, int]] = deque(maxlen=MOST_FRAMES)

    def add(self, refresh: Refresh) -> None:
        """Add a refresh; it may show the frame of the one before."""
        first_ns = refresh.shown_ns
        if self._kept and self._kept[-1][0] is refresh.transit:
            _, first_ns, _ = self._kept.pop()
        self._kept.append((refresh.transit, first_ns, refresh.shown_ns))

    def as_list(self) -> list[dict[str, Any]]:
        """Return the `timeline` of summary.json, in ms since the first of its frames was drawn."""
        if not self._kept:
            return []
        start_ns = self._kept[0][0].sent_ns
        return [
            {
                "frame": transit.number,
                "drawn": (transit.sent_ns - start_ns) * 1e-6,
                "parts": {name: part_ns * 1e-6 for name, part_ns in transit.parts_ns().items()},
                "shown": (first_ns - start_ns) * 1e-6,
                "until": (last_ns - start_ns) * 1e-6,
            }
            for transit, first_ns, last_ns in self._kept
        ]


Row = dict[str, Any]
Stages = Iterable[tuple[str, float]]
STAGE_COLUMNS = ("warp_ms", "fill_ms", "effects_ms", "lens_ms", "total_ms")
_NAMES = {prefix: tuple(f"{prefix}_{part}" for part in POSE_PARTS) for prefix in ("shown", "drawn")}


def row_of(number: int, refresh: Refresh, start_ns: int, speeds: Speeds, submitted_ns: int | None = None) -> Row:
    """Return the columns of a refresh that both eyes share; start_ns: the origin of time.

    None: not known, or not defined for the first picture.
    """
    head, frame, plan = refresh.head, refresh.frame, refresh.plan
    row: Row = {
        "frame": number,
        "time_s": (refresh.shown_ns - start_ns) * 1e-9,
        "shown_ns": refresh.shown_ns,
        "drawn_ns": frame.drawn_ns,
        "age_ms": refresh.age_ns * 1e-6,
        # From reading the head pose to submitting the picture.
        "pose_age_ms": None if submitted_ns is None or head.read_ns is None else (submitted_ns - head.read_ns) * 1e-6,
        "pose_origin": head.origin.name.lower(),
        "angular_speed_deg_s": speeds[0],
        "linear_speed_m_s": speeds[1],
        "warp": str(plan.choice),
        "fill": plan.fill,
    }
    for which, sample in (("shown", head), ("drawn", frame.head)):
        if sample is not None:
            values = (*sample.pose.position_m.tolist(), *sample.pose.orientation_xyzw.tolist())
            row |= dict(zip(_NAMES[which], values, strict=True))
    return row if frame.head is None else {**row, "drawn_origin": frame.head.origin.name.lower()}


def stage_columns(stages: Stages) -> Row:
    """Return times by the columns of frames.csv; 0 for a stage that is not in the plan."""
    columns = dict.fromkeys(STAGE_COLUMNS[:-1], 0.0)
    for name, milliseconds in stages:  # the client's own depth is for the warp, which reads it
        columns["warp_ms" if name == "client_depth" else f"{name}_ms"] += milliseconds
    return {**columns, "total_ms": sum(columns.values())}


def csv_text(rows: Iterable[Row]) -> str:
    """Return lines of frames.csv."""
    text = io.StringIO()
    csv.DictWriter(text, FRAME_COLUMNS, extrasaction="ignore", lineterminator="\n").writerows(rows)
    return text.getvalue()


_NOT_MEASURED = dict.fromkeys(QUALITY)


class ReplayLog:
    """Rows and response times of a replay."""

    def __init__(self, track: PoseTrack) -> None:
        self._track = track
        # Two for each refresh, keyed as frames.csv.
        self.rows: list[Row] = []
        # One for each refresh.
        self.responses: list[ResponseTime] = []
        self.timeline = Timeline()
        # When each refresh was seen, what instant its frame shows, and the head.
        self.seen: list[tuple[int, int, Pose]] = []

    def add(self, refresh: Refresh) -> None:
        # By central differences over 10 ms.
        before, after = (self._track.at(refresh.shown_ns + step_ns).pose for step_ns in (-_HALF_NS, _HALF_NS))
        row = row_of(len(self.seen), refresh, self._track.start_ns, _speeds(before, after, 2 * _HALF_NS * 1e-9))
        self.seen.append((refresh.shown_ns, refresh.frame.shows_ns, refresh.head.pose))
        self.responses.append(refresh.response)
        self.timeline.add(refresh)
        self.rows += [{**row, "eye": eye, **stage_columns(stages)} for eye, stages in enumerate(refresh.stage_ms)]

    def measured(self, figures: Mapping[tuple[int, int], Row]) -> None:
        """Add the figures of the measured refreshes, by (frame, eye)."""
        for row in self.rows:
            row.update(figures.get((row["frame"], row["eye"]), _NOT_MEASURED))

    def compared(self, times: Mapping[tuple[int, int], Stages], figures: Mapping[tuple[int, int], Row]) -> list[Row]:
        """Return rows of a comparison on some refreshes: own times and figures, the same heads."""
        return [
            {**row, **stage_columns(times[key]), **figures.get(key, _NOT_MEASURED)}
            for row in self.rows
            if (key := (row["frame"], row["eye"])) in times
        ]


@attrs.define(eq=False)
class Answers:
    """How long after each input a picture first showed what came of it."""

    # When the first picture was drawn: older inputs do not count.
    since_ns: int = 0
    _last_ns: int = 0
    _waiting: deque[int] = attrs.field(factory=deque)  # instants of inputs, the oldest first
    _took_ms: list[float] = attrs.field(factory=list)

    def add(self, event: InputEvent) -> None:
        """Add an input, later than those before."""
        if event.time_ns >= self.since_ns:
            self._waiting.append(event.time_ns)

    def see(self, shown_ns: int, shows_ns: int) -> None:
        """Take note of a picture: it shows what came of all inputs until an instant."""
        self._last_ns = shown_ns
        while self._waiting and self._waiting[0] <= shows_ns:
            self._took_ms.append((shown_ns - self._waiting.popleft()) * 1e-6)

    def entry(self) -> dict[str, Any]:
        """Return the `input` of summary.json: of inputs until the last picture."""
        took_ms = self._took_ms
        count = len(took_ms) + sum(at_ns <= self._last_ns for at_ns in self._waiting)
        if not took_ms:
            return {"count": count, "answered": 0}
        times = {"mean": float(np.mean(took_ms)), "p95": float(np.percentile(took_ms, 95)), "most": max(took_ms)}
        return {"count": count, "answered": len(took_ms), "response_time_ms": times}

    def note(self) -> str:
        entry = self.entry()
        if "response_time_ms" not in entry:
            return f"No picture showed what came of {entry['count']} inputs."
        times = entry["response_time_ms"]
        return (
            f"Response time, from an input to the first picture drawn after it: {times['mean']:.0f} ms on average, "
            f"{times['p95']:.0f} at the 95th percentile ({entry['answered']} of {entry['count']} inputs)."
        )


# Files that a run may write; a later run into the same folder removes those it does not write
# again.
OWNED = (
    *(f"images/*-{eye}.png" for eye in ("left", "right", "camera")),
    *(DIFF_PAGE, "frames.csv", "inputs.csv", "delays.csv", "jod.csv", "report.html", "replay.mp4"),
)
EYES = ("left", "right")


def summary_of(
    run: Run[Any],
    passes: tuple[str, str, str],
    trace: str,
    headset: str,
    rate_hz: float,
    trace_axes: str = "",
    assumptions: Sequence[Assumption] = (),
) -> dict[str, Any]:
    """Return the keys of summary.json that are settled when a run begins.

    passes: names of warp, fill and lens. rate_hz: of the display. trace_axes: in which a recorded
    trace was read, and who says so. assumptions: of its trace.
    """
    options, gpu, source, sizes = run.options, run.target.gpu, run.source, run.sizes
    plan, (view, *_), (warp, fill, lens) = run.loop.compensator.plan, run.target.eyes.views(Pose()), passes
    assumptions = (*assumptions, *source.assumptions)
    return {
        "schema": SCHEMA,
        "hmdwarp": __version__,
        "trace": trace,
        **({"trace_axes": trace_axes} if trace_axes else {}),
        "scene": source.scene.name,
        **({"recorded": source.entry} if source.entry is not None else {}),
        **({"assumptions": assumption_rows(assumptions)} if assumptions else {}),
        "effects": list(plan.effects),
        "latency_ms": options.latency_ms,
        **({"strategy": options.strategy} if options.strategy else {}),
        "warp": warp,
        "fill": fill,
        "lens": lens,
        "headset": headset,
        "size": list(sizes.shown),
        "frames": 0,
        "rate_hz": rate_hz,
        "server_rate_hz": options.network.server_rate_hz,
        "guard": options.guard_band.factors(sizes.shown).entry,
        "rendered": rendered_entry(options.guard_band, sizes, plan.needs),
        "predict": options.predict,
        "pixels_per_degree": view.fov.pixels_per_degree(sizes.shown),
        "machine": machine_of(gpu),
        "clock": gpu.timer.clock,
        "made_with": {**made_with(), "options": options.digest()},
    }


def machine_of(gpu: Gpu) -> dict[str, Any]:
    """Return the `machine` of summary.json."""
    return {"gl_renderer": gpu.renderer, "gl_version": gpu.version, "cpu_count": os.cpu_count() or 1}


_OF_COMPARISON = ("warp", "fill", "lens", "time_ms", "quality", "difference")


@attrs.frozen(eq=False)
class ReplayResult:
    """Results of a replay."""

    folder: Path
    # As summary.json.
    summary: dict[str, Any]
    # Two for each refresh, keyed as frames.csv.
    rows: list[Row]
    # The summaries of the comparisons.
    against: list[dict[str, Any]]
    # What came of the requirements and the baseline, None where there are none.
    verdict: Verdict | None = None

    @property
    def report(self) -> Path:
        return self.folder / "report.html"

    def __repr__(self) -> str:
        about, means = self.summary, {one.name: self.summary["quality"][one.name]["mean"] for one in metrics_in_order()}
        found = [metric.figure for metric in metrics_in_order() if metric.tile_note and means[metric.name] is not None]
        figures = ", ".join(f"{one.label} {one.text(means[one.name])} {one.unit}".strip() for one in found)
        run = f"{about['trace']}, {about['scene']}, {about['latency_ms']:g} ms, {about['warp']} + {about['fill']}"
        return f"<ReplayResult {run}: {figures}; {self.report}>"

    def _repr_html_(self) -> str:
        return summary_html(self.summary, *self.against)


def summary_of_rows(setup: ReplayRun, passes: tuple[str, str, str], rows: list[Row]) -> dict[str, Any]:
    """Return the keys of summary.json for the named passes; rows: as of frames.csv."""
    name, headset = setup.track.name or setup.trace.path.stem, setup.source.headset
    views, hidden, notes = headset.views(Pose()), dict[str, Any](), list[str]()
    if any(view.hidden is not None for view in views):
        share = 1 - sum(float(view.seen(setup.sizes.shown).mean()) for view in views) / len(views)
        hidden = {"hidden": {"share": share}}
        notes = [f"The lens hides {share:.1%} of each picture: it is neither drawn, warped nor counted."]
    trace, rate_hz = setup.trace, setup.schedule.rate_hz
    about = summary_of(setup, passes, name, headset.name, rate_hz, setup.track.axes, trace.assumptions)
    return {
        **about,
        "frames": len({row["frame"] for row in rows}),
        **aggregate(rows),
        **hidden,
        "notes": [*setup.notes, *notes],
    }


def result_of(
    setup: ReplayRun, log: ReplayLog, compared: list[list[Row]], more: dict[str, Any], without_truth: int = 0
) -> ReplayResult:
    """Return the summaries of a run and of its comparisons; more: other measurements, by key."""
    options, rows = setup.options, log.rows
    if setup.source.scene.inputs:
        first_ns = setup.schedule.first_ns - setup.schedule.age_ns
        answers = Answers(first_ns)
        for event in setup.source.scene.inputs:
            answers.add(event)
        for shown_ns, shows_ns, _ in log.seen:
            answers.see(shown_ns, shows_ns)
        setup.notes.append(answers.note())
        more = {**more, "input": answers.entry()}
    summary = summary_of_rows(setup, (options.warp, options.fill, options.lens), rows)
    summary["link"] = {
        **setup.channel.summary(setup.schedule.rate_hz),
        "response": options.network.response,
        "response_ms": figures_of_parts([[*time.parts().values()] for time in log.responses]),
        "timeline": log.timeline.as_list(),
    }
    summary |= more
    shown = [(shown_ns, pose) for shown_ns, _, pose in log.seen]
    facts, about = setup.server.truth_facts(shown, without_truth, setup.pixels_per_degree, own_head=not options.trace)
    summary |= facts
    if about:
        setup.notes.append(about)
        summary["notes"] = setup.notes
    if weights := setup.geometry.weights():
        summary["client_models"] = weights
    result = ReplayResult(options.out, summary, rows, [])
    for pair, its_rows in zip(options.compared, compared, strict=False):
        other = summary_of_rows(setup, (*pair, "none"), its_rows)
        other["difference"] = {name: difference(rows, its_rows, name) for name in QUALITY}
        result.against.append(other)
        summary.setdefault("against", []).append({key: other[key] for key in _OF_COMPARISON if key in other})
    return result


Judge = Callable[[ReplayResult, StoredRun], Verdict]


def write_results(
    out: OutputFolder,
    log: ReplayLog,
    result: ReplayResult,
    compared: list[list[Row]],
    pool: QualityPool,
    command: str,
    judge: Judge | None,
) -> Verdict | None:
    """Write everything but the video, which is written during the run; return the verdict."""
    # Pictures are encoded on threads while the page is made: one after the other they took longer.
    with ThreadPoolExecutor(thread_name_prefix="pictures") as encoders:

        def write_strip(kept: Kept) -> tuple[str, list[Panel]]:
            number, eye, _ = kept.key
            name, panels = f"images/frame-{number:06d}-{names[eye]}.png", in_a_row(columns_of(kept))
            out.write_png(name, labelled_strip(panels))
            return name, panels

        def digested() -> dict[str, Any]:
            return digests(log.rows, dict(strip.result() for strip in strips))

        names = EYES if result.summary.get("eyes", 2) == 2 else ("camera",)
        strips = [encoders.submit(write_strip, kept) for kept in pool.kept]
        out.write_csv("frames.csv", log.rows, FRAME_COLUMNS)
        time_s = {row["frame"]: row["time_s"] for row in result.rows}
        verdict = None
        if judge is not None:
            result.summary["digests"] = digested()
            verdict = judge(result, StoredRun(out.path(""), result.summary, out.folder))
            result.summary["gate"] = verdict.entry()
        if verdict is not None and verdict.diff is not None and not verdict.diff.is_equal:
            out.write_text(DIFF_PAGE, verdict.diff.page(command))
        page = render_report(
            result.summary,
            result.against,
            rows=result.rows,
            baselines_rows=compared,
            worst=[WorstFrame(time_s[k.key[0]], k.key[1], columns_of(k), k.result.values) for k in pool.worst],
            command=command,
            notes=result.summary["notes"],
            gate=verdict.section() if verdict is not None else None,
        )
        out.write_text("report.html", page)
        result.summary["digests"] = digested()
    out.write_json("summary.json", result.summary)
    return verdict
