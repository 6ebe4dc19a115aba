"""Keys of summary.json that a replay, a live run and a row of a bench share; files of a replay."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import attrs

from ..geometry import Pose
from ..gpu.context import Gpu
from ..link import figures_of_parts
from ..metrics import QUALITY, Kept, QualityPool, aggregate, difference, metrics_in_order
from ..pipeline.sizes import rendered_entry
from ..poses.assumptions import Assumption, assumption_rows
from ..report import (
    DIFF_PAGE,
    FRAME_COLUMNS,
    SCHEMA,
    OutputFolder,
    Panel,
    StoredRun,
    WorstFrame,
    digests,
    labelled_strip,
    panels_of,
    render_report,
    summary_html,
)
from ..resources import __version__, made_with
from .frame_rows import ANSWER_COLUMNS, Answers, ReplayLog, Row
from .requirements import Verdict
from .run import ReplayRun, Run

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
    measured, notes = aggregate(rows), []
    views, size, figures = headset.views(Pose()), setup.sizes.shown, [one.figure for one in metrics_in_order()]
    hidden: dict[str, Any] = {}
    if any(view.hidden is not None for view in views):
        # The share of the shown pixels, and the means if hidden ones, which are black and alike,
        # counted too.
        seen = sum(float(view.seen(size).mean()) for view in views) / len(views)
        means = {one.name: one.of_all(measured["quality"][one.name]["mean"], seen) for one in metrics_in_order()}
        hidden = {"hidden": {"share": 1 - seen, "quality": means}}
        told = (f"{one.label} {one.text(means[one.name])} {one.unit}".strip() for one in figures)
        notes = [
            f"The lens hides {1 - seen:.1%} of each picture: it is neither drawn, warped nor counted. "
            f"With it, all black, the means are: {', '.join(told)}."
        ]
    trace, rate_hz = setup.trace, setup.schedule.rate_hz
    about = summary_of(setup, passes, name, headset.name, rate_hz, setup.track.axes, trace.assumptions)
    return {
        **about,
        "frames": len({row["frame"] for row in rows}),
        **measured,
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
        log.answers = Answers(first_ns, epoch_ns=setup.trace.track.epoch_ns)
        for event in setup.source.scene.inputs:
            log.answers.add(event)
        for moment in log.moments:
            log.answers.see(moment.figures["shown_ns"], moment.shows_ns)
        setup.notes.append(log.answers.note())
        more = {**more, "input": log.answers.entry()}
    summary = summary_of_rows(setup, (options.warp, options.fill, options.lens), rows)
    summary["link"] = {
        **setup.channel.summary(setup.schedule.rate_hz),
        "response": options.network.response,
        "response_ms": figures_of_parts([[*time.parts().values()] for time in log.responses]),
        "timeline": log.timeline.as_list(),
    }
    summary |= more
    shown = [(moment.figures["shown_ns"], moment.shown.pose) for moment in log.moments]
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
            name, panels = f"images/frame-{number:06d}-{names[eye]}.png", panels_of(kept)
            out.write_png(name, labelled_strip(panels))
            return name, panels

        def digested() -> dict[str, Any]:
            return digests([*log.frames_csv()], dict(strip.result() for strip in strips))

        names = EYES if result.summary.get("eyes", 2) == 2 else ("camera",)
        strips = [encoders.submit(write_strip, kept) for kept in pool.kept]
        out.write_csv("frames.csv", log.frames_csv(), FRAME_COLUMNS)
        if log.answers is not None:
            out.write_csv("inputs.csv", log.answers.rows(), ANSWER_COLUMNS)
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
            worst=[WorstFrame.of(time_s[kept.key[0]], kept.key[1], kept) for kept in pool.worst],
            command=command,
            notes=result.summary["notes"],
            gate=verdict.section() if verdict is not None else None,
        )
        out.write_text("report.html", page)
        result.summary["digests"] = digested()
    out.write_json("summary.json", result.summary)
    return verdict
