"""All experiments: what has to be run, the verdicts, and the files."""

from __future__ import annotations

import base64
import itertools
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from ..gpu import Gpu
from ..report import OutputFolder, jpeg_bytes, plain, render_thesis_page
from ..run.run_summary import machine_of
from ..version import __version__
from .experiment import Experiment
from .facts import fact, ratings
from .kept_runs import KEPT, PICTURE, TIMELINE, TRUTH, KeptRuns, fingerprint
from .library import experiments_named
from .options import QUICK_SCALE, ThesisOptions
from .picture_runs import Thoroughness, look
from .run_kinds import Figures, PictureRun, RatingsRun, Run, StreamRun, is_quick
from .stream_runs import stream
from .verdicts import Finding, Verdict, settings_text, verdict_of

SCHEMA = 1
PAGE, TABLE, DATA = "thesis.html", "results.csv", "results.json"
COLUMNS = ("experiment", "source", "row", "column", "measured", "value", "unit", "holds", "rule", "verdict")
PAGE_WIDTH = 560
Progress = Callable[[int, int], None]
Say = Callable[[str], None]


@attrs.frozen(eq=False)
class ThesisResult:
    """What was found, as in results.json, and where it lies."""

    folder: Path
    data: dict[str, Any]

    @property
    def report(self) -> Path:
        """The page."""
        return self.folder / PAGE


def run_thesis(
    options: ThesisOptions, progress: Progress = lambda done, total: None, say: Say = lambda text: None
) -> ThesisResult:
    """Run the experiments and write the page, results.json and results.csv into options.out.

    Finished runs stay in the folder `kept`, also of a command that was killed; the next one uses
    those that were made with the same things. progress(done, total): in runs. say: gets a sentence.
    Errors: InputError and its kin for a folder that cannot be written, MachineError for what the
    machine lacks.
    """
    started = time.perf_counter()
    chosen = [_quick(one) if options.quick else one for one in experiments_named(options.only)]
    with OutputFolder(options.out, owned=(PAGE, TABLE), last=DATA, force=options.force) as out:
        how = Thoroughness(options.eye_size, *((1, 2) if options.quick else (3, 5)))
        with Gpu() as gpu:
            machine, clock = machine_of(gpu), gpu.timer.clock
        made_with = {
            "hmdwarp": __version__,
            "program": fingerprint(),
            "gl_renderer": machine["gl_renderer"],
            "stream_s": 0.25 if options.quick else 1.0,
            "stream_scale": QUICK_SCALE if options.quick else 1.0,
            **attrs.asdict(how),
        }
        kept = KeptRuns(options.out / KEPT, made_with)
        figures = _figures(chosen, how, kept, progress, say)
        judged = [_judged(one, figures) for one in chosen]
        data = {
            "schema": SCHEMA,
            "hmdwarp": __version__,
            "command": options.command,
            "machine": machine,
            "clock": clock,
            "size": list(options.eye_size),
            "quick": options.quick,
            "verdicts": _counts(judged),
            "experiments": judged,
            "seconds": time.perf_counter() - started,
        }
        out.write_text(PAGE, render_thesis_page(data, _pictures(chosen, kept)))
        out.write_csv(TABLE, _rows(judged), COLUMNS)
        out.write_json(DATA, data)
    return ThesisResult(options.out, data)


def _quick(one: Experiment) -> Experiment:
    """Return the experiment with the middle speed of each motion only."""
    cells = tuple(cell for cell in one.cells if all(is_quick(run) for run in cell.runs))
    return attrs.evolve(one, cells=cells or one.cells)


def _figures(
    chosen: Sequence[Experiment], how: Thoroughness, kept: KeptRuns, progress: Progress, say: Say
) -> dict[Run, Figures]:
    """Return the figures of every run, those that are not kept by running them."""
    kept.folder.mkdir(exist_ok=True)
    pictured = {run for one in chosen for run in one.pictures}
    runs = list(dict.fromkeys(run for one in chosen for run in one.runs()))
    found: dict[Run, Figures] = {}
    for run in runs:
        known = kept.load(run, with_picture=run in pictured)
        if known is not None:
            found[run] = known
    if found:
        say(f"{len(found)} of {len(runs)} runs are kept from before in {kept.folder}")
    progress(len(found), len(runs))
    with tempfile.TemporaryDirectory(prefix="hmdwarp-thesis-") as name:
        for run, figures in _run_all([run for run in runs if run not in found], how, kept, pictured, Path(name)):
            found[run] = figures
            progress(len(found), len(runs))
    return found


def _run_all(
    runs: Sequence[Run], how: Thoroughness, kept: KeptRuns, pictured: set[PictureRun | StreamRun], folder: Path
) -> Iterator[tuple[Run, Figures]]:
    """Yield the figures of each run as soon as it is kept."""
    pictures = [run for run in runs if isinstance(run, PictureRun)]
    order = {shared: number for number, shared in enumerate(dict.fromkeys(run.shared for run in pictures))}
    for _, group in itertools.groupby(sorted(pictures, key=lambda run: order[run.shared]), lambda run: run.shared):
        for looked in look(tuple(group), how, folder):
            images = {PICTURE: looked.picture, TRUTH: looked.truth} if looked.run in pictured else {}
            kept.keep(looked.run, looked.figures, images)
            yield looked.run, looked.figures
    for run in runs:
        if isinstance(run, PictureRun):
            continue
        timeline: dict[str, str] = {}
        if isinstance(run, StreamRun):
            figures, drawn = stream(run, kept.made_with["stream_scale"], kept.made_with["stream_s"])
            timeline = {TIMELINE: drawn} if run in pictured else {}
        else:
            figures = ratings(run) if isinstance(run, RatingsRun) else fact(run)
        kept.keep(run, figures, timeline)
        yield run, figures


def _judged(one: Experiment, figures: Mapping[Run, Figures]) -> dict[str, Any]:
    """Return an experiment as plain data, with the number of each cell and the verdict."""
    findings = [
        Finding.of(
            cell.row,
            cell.column,
            (cell.value or one.value)([figures[run] for run in cell.runs]),
            cell.rule or one.rule,
        )
        for cell in one.cells
    ]
    verdict = verdict_of(findings)
    return {
        "name": one.name,
        "source": one.source,
        "claim": one.claim,
        "thesis": one.thesis,
        "measured": one.measured,
        "unit": one.unit,
        "digits": one.digits,
        "scale": one.scale,
        "rule": one.rule_words(),
        "ours": _ours(one, findings),
        "verdict": verdict.value,
        "holds_at": settings_text(findings, True),
        "fails_at": settings_text(findings, False),
        "unknown_at": settings_text(findings, None),
        "note": one.note,
        "cells": [attrs.asdict(finding) for finding in findings],
    }


def _ours(one: Experiment, findings: Sequence[Finding]) -> str:
    """Return the range of our numbers."""
    values = sorted(finding.value * one.scale for finding in findings if finding.value is not None)
    if not values:
        return ""
    ends = list(dict.fromkeys(plain(value, one.digits) for value in (values[0], values[-1])))
    return f"{' to '.join(ends)} {one.unit}".strip()


def _counts(experiments: Sequence[Mapping[str, Any]]) -> dict[str, int]:
    counted = Counter(one["verdict"] for one in experiments)
    return {verdict.value: counted[verdict.value] for verdict in Verdict}


def _rows(experiments: Sequence[Mapping[str, Any]]) -> Iterator[dict[str, Any]]:
    for one in experiments:
        same = {
            "experiment": one["name"],
            **{name: one[name] for name in ("source", "measured", "unit", "rule", "verdict")},
        }
        for cell in one["cells"]:
            value = None if cell["value"] is None else cell["value"] * one["scale"]
            holds = {None: None, True: "yes", False: "no"}[cell["holds"]]
            yield {**same, "row": cell["row"], "column": cell["column"], "value": value, "holds": holds}


def _pictures(chosen: Sequence[Experiment], kept: KeptRuns) -> dict[str, list[tuple[str, str]]]:
    """Return (caption, data URI or <svg> element) of each experiment's pictures, by its name."""
    return {one.name: [*_pictures_of(one, kept)] for one in chosen}


def _pictures_of(one: Experiment, kept: KeptRuns) -> Iterator[tuple[str, str]]:
    pictures = [run for run in one.pictures if isinstance(run, PictureRun)]
    for run in pictures:
        yield run.caption, _uri(kept.picture(run, PICTURE))
    for run in {(run.scene, run.motion): run for run in pictures}.values():
        yield f"what should be seen: {run.motion}", _uri(kept.picture(run, TRUTH))
    for stream_run in one.pictures:
        if isinstance(stream_run, StreamRun):
            yield stream_run.caption, kept.picture(stream_run, TIMELINE).read_text(encoding="utf-8")


def _uri(path: Path) -> str:
    """Return a picture at most PAGE_WIDTH pixels wide."""
    from PIL import Image

    picture = Image.open(path)
    picture.thumbnail((PAGE_WIDTH, PAGE_WIDTH), Image.Resampling.LANCZOS)
    return f"data:image/jpeg;base64,{base64.b64encode(jpeg_bytes(np.asarray(picture))).decode()}"
