"""Output of a replay: summary.json, frames.csv, pictures and the page."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..link import response_figures
from ..metrics import QUALITY, Kept, QualityPool, aggregate, difference
from ..report import FRAME_COLUMNS, OutputFolder, WorstFrame, comparison_panels, digests, labelled_strip, render_report
from .frame_rows import Row
from .log import ReplayLog
from .replay_setup import ReplaySetup
from .run_summary import Facts, auto_entry, auto_note, chosen_passes, eye_names

_OF_COMPARISON = ("warp", "fill", "lens", "time_ms", "quality", "difference", "miss")


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

    @property
    def report(self) -> Path:
        """Path of the page."""
        return self.folder / "report.html"


def summary_of_rows(setup: ReplaySetup, passes: tuple[str, str, str], rows: list[Row]) -> dict[str, Any]:
    """Return the keys of summary.json for the named passes on the frames of `setup`.

    rows: as of frames.csv; those of one frame may be several.
    """
    name = setup.track.name or setup.trace.path.stem
    rate_hz, trace = setup.schedule.rate_hz, setup.trace
    facts = Facts.of(setup.pipeline, name, setup.headset.name, rate_hz, setup.track.axes, trace.assumptions)
    frames = len({row["frame"] for row in rows})
    return facts.summary(passes, frames, {**aggregate(rows), "notes": setup.notes})


def result_of(
    setup: ReplaySetup, log: ReplayLog, compared: list[list[Row]], more: dict[str, Any], without_truth: int = 0
) -> ReplayResult:
    """Return the summaries of a run and of its comparisons.

    more: other measurements, by key. without_truth: pictures that were to be measured.
    """
    options, rows, auto = setup.options, log.rows, setup.auto
    summary = summary_of_rows(setup, chosen_passes(options, options.lens), rows)
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
    if weights := setup.pipeline.geometry.weights():
        summary["client_models"] = weights
    if auto is not None:
        summary["auto"] = auto_entry(auto, rows)
        summary["notes"] = [*setup.notes, auto_note(summary["auto"], rows)]
    result = ReplayResult(options.out, summary, rows, [])
    for pair, its_rows in zip(options.compared, compared, strict=False):
        compare(result, summary_of_rows(setup, (*pair, "none"), its_rows), its_rows)
    return result


def compare(result: ReplayResult, other: dict[str, Any], its_rows: list[Row]) -> None:
    """Add the summary of another run of the same refreshes to the comparisons."""
    other["difference"] = {name: difference(result.rows, its_rows, name) for name in QUALITY}
    result.against.append(other)
    entry = {key: other[key] for key in _OF_COMPARISON if key in other}
    result.summary.setdefault("against", []).append(entry)


def write_results(
    out: OutputFolder,
    log: ReplayLog,
    result: ReplayResult,
    compared: list[list[Row]],
    pool: QualityPool,
    misses: list[list[Row]],
    command: str,
) -> None:
    """Write everything but the video, which is written during the run.

    Pictures are encoded on threads while the page is made: one after the other they took longer.
    """
    with ThreadPoolExecutor(thread_name_prefix="pictures") as encoders:
        strips = [encoders.submit(_write_strip, out, kept, eye_names(result.summary)) for kept in pool.kept]
        out.write_csv("frames.csv", log.frames_csv(), FRAME_COLUMNS)
        page = render_report(
            result.summary,
            result.against,
            rows=result.rows,
            baselines_rows=compared,
            misses=misses,
            worst=[_worst_frame(result.rows, kept) for kept in pool.worst],
            command=command,
            notes=result.summary["notes"],
        )
        out.write_text("report.html", page)
        pictures = dict(strip.result() for strip in strips)
    result.summary["digests"] = digests([*log.frames_csv()], pictures)
    out.write_json("summary.json", result.summary)


def _write_strip(out: OutputFolder, kept: Kept, names: Sequence[str]) -> tuple[str, NDArray[np.uint8]]:
    number, eye, _ = kept.key
    name, strip = f"images/frame-{number:06d}-{names[eye]}.png", labelled_strip(_panels_of(kept))
    out.write_png(name, strip)
    return name, strip


def _panels_of(kept: Kept) -> list[tuple[str, NDArray[np.uint8]]]:
    assert kept.result.error_map is not None
    return comparison_panels(kept.job.rendered_picture, kept.job.now.shown, kept.job.now.truth, kept.result.error_map)


def _worst_frame(rows: list[Row], kept: Kept) -> WorstFrame:
    number, eye, _ = kept.key
    time_s = next(row["time_s"] for row in rows if row["frame"] == number)
    return WorstFrame.of(time_s, eye, kept)
