"""All experiments: what has to be run, the verdicts, and the files."""

from __future__ import annotations

import base64
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from ...report import OutputFolder, jpeg_bytes, plain, render_thesis_page
from ...resources import __version__
from ..sweep import SweepCase, Swept, raise_failures, run_cases
from .experiment import Experiment
from .library import EXPERIMENTS, experiments_named
from .options import QUICK_SCALE, ThesisOptions
from .picture_runs import Thoroughness
from .run_kinds import Figures, PictureRun, Run, StreamRun, is_quick
from .thesis_work import PICTURE, TIMELINE, TRUTH, Ratings, ThesisWork, cases_of
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
    # The runs, and which failed: raise_failures tells of them.
    swept: Swept

    @property
    def report(self) -> Path:
        """The page."""
        return self.folder / PAGE


def run_thesis(
    options: ThesisOptions,
    ratings: Ratings,
    progress: Progress = lambda done, total: None,
    say: Say = lambda text: None,
) -> ThesisResult:
    """Run the experiments and write the page, results.json and results.csv into options.out.

    Each run is a case, kept in the folder `cases` there as soon as it is done. One that fails
    leaves the others, see ThesisResult.swept. ratings: what the published ratings say; a function
    of a module, as it crosses to other machines by pickle. progress(done, total): in runs. say:
    gets a sentence.
    Errors: InputError and its kin for a folder that cannot be written, MachineError for what the
    machine lacks; that of the run where none of several was done.
    """
    started = time.perf_counter()
    chosen = [_quick(one) if options.quick else one for one in experiments_named(options.only)]
    with OutputFolder(options.out, owned=(PAGE, TABLE), last=DATA, force=options.force) as out:
        how = Thoroughness(options.eye_size, *((1, 2, QUICK_SCALE, 0.25) if options.quick else (3, 5)))
        runs = tuple(dict.fromkeys(run for one in chosen for run in one.runs()))
        # Of any experiment, not only of those chosen: what is kept serves another choice too.
        pictured: set[Run] = {run for one in EXPERIMENTS for run in one.pictures}
        cases = cases_of(runs, pictured, how)
        swept = run_cases(ThesisWork(runs, ratings), cases, options.out, options.sweep, progress, say)
        if not (figures := _figures(swept.results())):
            raise_failures(swept)
        made_on = next(data for _, data in swept.results())
        judged = [_judged(one, figures) for one in chosen]
        data = {
            "schema": SCHEMA,
            "hmdwarp": __version__,
            "command": options.command,
            "machine": made_on["machine"],
            "clock": made_on["clock"],
            "size": list(options.eye_size),
            "quick": options.quick,
            "verdicts": _counts(judged),
            "experiments": judged,
            "failed": [f"{one.name}: {one.why}" for one in swept.failed],
            "seconds": time.perf_counter() - started,
        }
        out.write_text(PAGE, render_thesis_page(data, _pictures(chosen, swept)))
        out.write_csv(TABLE, _rows(judged), COLUMNS)
        out.write_json(DATA, data)
    return ThesisResult(options.out, data, swept)


def _quick(one: Experiment) -> Experiment:
    """Return the experiment with the middle speed of each motion only."""
    cells = tuple(cell for cell in one.cells if all(is_quick(run) for run in cell.runs))
    return attrs.evolve(one, cells=cells or one.cells)


def _figures(results: Iterable[tuple[SweepCase, Mapping[str, Any]]]) -> dict[Run, Figures]:
    """Return the figures of every run; times of another machine than the first's are left out."""
    found: dict[Run, Figures] = {}
    timed_on: Any = None
    for case, data in results:
        run, figures = case.what.run, data["figures"]
        if isinstance(run, PictureRun) and run.timed:
            timed_on = timed_on or data["machine"]
            if data["machine"] != timed_on:
                figures = {name: value for name, value in figures.items() if not name.endswith("_ms")}
        found[run] = figures
    return found


def _judged(one: Experiment, figures: Mapping[Run, Figures]) -> dict[str, Any]:
    """Return an experiment as plain data, with the number of each cell and the verdict.

    A cell one of whose runs failed has no number.
    """
    findings = []
    for cell in one.cells:
        known = [figures[run] for run in cell.runs if run in figures]
        value = (cell.value or one.value)(known) if len(known) == len(cell.runs) else None
        findings.append(Finding.of(cell.row, cell.column, value, cell.rule or one.rule))
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


def _pictures(chosen: Sequence[Experiment], swept: Swept) -> dict[str, list[tuple[str, str]]]:
    """Return (caption, data URI or <svg> element) of each experiment's pictures, by its name."""
    done = {case.what.run: case.identity for case, _ in swept.results()}

    def file(run: Run, name: str) -> Path:
        return swept.kept.file(done[run], name)

    return {one.name: [*_pictures_of([run for run in one.pictures if run in done], file)] for one in chosen}


def _pictures_of(
    pictured: Sequence[PictureRun | StreamRun], file: Callable[[Run, str], Path]
) -> Iterator[tuple[str, str]]:
    pictures = [run for run in pictured if isinstance(run, PictureRun)]
    for run in pictures:
        yield run.caption, _uri(file(run, PICTURE))
    for run in {(run.scene, run.motion): run for run in pictures}.values():
        yield f"what should be seen: {run.motion}", _uri(file(run, TRUTH))
    for stream_run in pictured:
        if isinstance(stream_run, StreamRun):
            yield stream_run.caption, file(stream_run, TIMELINE).read_text(encoding="utf-8")


def _uri(path: Path) -> str:
    """Return a picture at most PAGE_WIDTH pixels wide."""
    from PIL import Image

    picture = Image.open(path)
    picture.thumbnail((PAGE_WIDTH, PAGE_WIDTH), Image.Resampling.LANCZOS)
    return f"data:image/jpeg;base64,{base64.b64encode(jpeg_bytes(np.asarray(picture))).decode()}"
