"""Keys of summary.json that a replay, a live run and a row of a bench share.

Includes the entry of warp "auto".
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import attrs

from ..frames import EyeSizes, Needs
from ..geometry import Pose, View
from ..gpu.context import Gpu
from ..link import response_figures
from ..metrics import QUALITY, Kept, QualityPool, aggregate, difference, metrics_in_order
from ..pipeline.options import PipelineOptions
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
from .replay_setup import ReplayRun
from .requirements import Verdict
from .run import Run

# Files that a run may write; a later run into the same folder removes those it does not write
# again.
OWNED = (
    *(f"images/*-{eye}.png" for eye in ("left", "right", "camera")),
    *(DIFF_PAGE, "frames.csv", "inputs.csv", "delays.csv", "jod.csv", "report.html", "replay.mp4"),
)
EYES = ("left", "right")


@attrs.frozen(eq=False)
class Facts:
    """Facts settled when a run begins."""

    options: PipelineOptions
    # Name of the head motion.
    trace: str
    scene: str
    effects: list[str]
    headset: str
    sizes: EyeSizes
    rate_hz: float
    pixels_per_degree: float
    machine: dict[str, Any]
    # "gpu" or "wall".
    clock: str
    # What its frames carry, as its plan wants it.
    needs: Needs = Needs()
    # Axes in which a recorded trace was read, and who says so; empty for a head that is live.
    trace_axes: str = ""
    # Of recorded frames: folder, layout, frames, size, fov_deg and eye_distance_mm.
    recorded: dict[str, Any] | None = None
    # Facts by which trace and frames were read, with who says so.
    assumptions: tuple[Assumption, ...] = ()

    @classmethod
    def of(
        cls,
        run: Run[Any],
        trace: str,
        headset: str,
        rate_hz: float,
        trace_axes: str = "",
        assumptions: tuple[Assumption, ...] = (),
    ) -> Facts:
        """Return the facts of a run.

        rate_hz: of the display. assumptions: of its trace.
        """
        gpu, source, plan = run.target.gpu, run.source, run.loop.compensator.plan
        (view, *_) = run.target.eyes.views(Pose())
        return cls(
            options=run.options,
            trace=trace,
            scene=source.scene.name,
            effects=list(plan.effects),
            headset=headset,
            sizes=run.sizes,
            rate_hz=rate_hz,
            pixels_per_degree=view.fov.pixels_per_degree(run.sizes.shown),
            machine=machine_of(gpu),
            clock=gpu.timer.clock,
            needs=plan.needs,
            trace_axes=trace_axes,
            recorded=source.entry,
            assumptions=(*assumptions, *source.assumptions),
        )

    def summary(self, passes: tuple[str, str, str], frames: int, figures: Mapping[str, Any]) -> dict[str, Any]:
        """Return the keys of summary.json.

        passes: names of warp, fill and lens. frames: number of shown refreshes. figures: `time_ms`,
        `quality` and any further keys.
        """
        options, (warp, fill, lens) = self.options, passes
        return {
            "schema": SCHEMA,
            "hmdwarp": __version__,
            "trace": self.trace,
            **({"trace_axes": self.trace_axes} if self.trace_axes else {}),
            "scene": self.scene,
            **({"recorded": self.recorded} if self.recorded is not None else {}),
            **({"assumptions": assumption_rows(self.assumptions)} if self.assumptions else {}),
            "effects": self.effects,
            "latency_ms": options.latency_ms,
            **({"strategy": options.strategy} if options.strategy else {}),
            "warp": warp,
            "fill": fill,
            "lens": lens,
            "headset": self.headset,
            "size": list(self.sizes.shown),
            "frames": frames,
            "rate_hz": self.rate_hz,
            "server_rate_hz": options.network.server_rate_hz,
            "guard": options.guard_band.factors(self.sizes.shown).entry,
            "rendered": rendered_entry(options.guard_band, self.sizes, self.needs),
            "predict": options.predict,
            "pixels_per_degree": self.pixels_per_degree,
            "machine": self.machine,
            "clock": self.clock,
            "made_with": {**made_with(), "options": options.digest()},
            **figures,
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
        """Path of the page."""
        return self.folder / "report.html"

    def __repr__(self) -> str:
        about, means = self.summary, {one.name: self.summary["quality"][one.name]["mean"] for one in metrics_in_order()}
        found = [metric.figure for metric in metrics_in_order() if metric.tile_note and means[metric.name] is not None]
        figures = ", ".join(f"{one.label} {one.text(means[one.name])} {one.unit}".strip() for one in found)
        run = f"{about['trace']}, {about['scene']}, {about['latency_ms']:g} ms, {about['warp']} + {about['fill']}"
        return f"<ReplayResult {run}: {figures}; {self.report}>"

    def _repr_html_(self) -> str:
        """Return the table that ends a run: a notebook shows it."""
        return summary_html(self.summary, *self.against)


def summary_of_rows(setup: ReplayRun, passes: tuple[str, str, str], rows: list[Row]) -> dict[str, Any]:
    """Return the keys of summary.json for the named passes on the frames of `setup`.

    rows: as of frames.csv; those of one frame may be several.
    """
    name = setup.track.name or setup.trace.path.stem
    rate_hz, trace = setup.schedule.rate_hz, setup.trace
    facts = Facts.of(setup, name, setup.source.headset.name, rate_hz, setup.track.axes, trace.assumptions)
    frames = len({row["frame"] for row in rows})
    measured = aggregate(rows)
    hidden, notes = hidden_entry(setup.source.headset.views(Pose()), setup.sizes.shown, measured["quality"]), []
    if hidden:
        means = (
            f"{one.label} {one.text(hidden['hidden']['quality'][one.name])} {one.unit}".strip()
            for one in (metric.figure for metric in metrics_in_order())
        )
        notes = [
            f"The lens hides {hidden['hidden']['share']:.1%} of each picture: it is neither drawn, warped nor counted. "
            f"With it, all black, the means are: {', '.join(means)}."
        ]
    return facts.summary(passes, frames, {**measured, **hidden, "notes": [*setup.notes, *notes]})


def hidden_entry(
    views: Sequence[View], size: tuple[int, int], quality: Mapping[str, Mapping[str, Any]]
) -> dict[str, Any]:
    """Return the `hidden` of summary.json, none where lenses hide nothing.

    share: of the shown pixels. quality: the means if hidden pixels, which are black and alike,
    counted too.
    """
    if all(view.hidden is None for view in views):
        return {}
    seen = sum(float(view.seen(size).mean()) for view in views) / len(views)
    means = {one.name: one.of_all(quality[one.name]["mean"], seen) for one in metrics_in_order()}
    return {"hidden": {"share": 1 - seen, "quality": means}}


def result_of(
    setup: ReplayRun, log: ReplayLog, compared: list[list[Row]], more: dict[str, Any], without_truth: int = 0
) -> ReplayResult:
    """Return the summaries of a run and of its comparisons.

    more: other measurements, by key. without_truth: pictures that were to be measured.
    """
    options, rows = setup.options, log.rows
    if setup.source.scene.inputs:
        first_ns = setup.schedule.first_ns - setup.schedule.age_ns
        log.answers = Answers(first_ns, epoch_ns=setup.trace.track.epoch_ns)
        for event in setup.source.scene.inputs:
            log.answers.add(event)
        for moment in log.moments:
            log.answers.see(moment.shown_ns, moment.shows_ns)
        setup.notes.append(log.answers.note())
        more = {**more, "input": log.answers.entry()}
    summary = summary_of_rows(setup, (options.warp, options.fill, options.lens), rows)
    summary["link"] = {
        **setup.channel.summary(setup.schedule.rate_hz),
        "response": "fixed" if options.network.response is None else "sum",
        "response_ms": response_figures(log.responses),
        "timeline": log.timeline.as_list(),
    }
    summary |= more
    shown = [(moment.shown_ns, moment.shown.pose) for moment in log.moments]
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
    """Write everything but the video, which is written during the run; return the verdict.

    Pictures are encoded on threads while the page is made: one after the other they took longer.
    """
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
