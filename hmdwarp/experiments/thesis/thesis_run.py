"""`hmdwarp thesis`: every run is a case; from their figures come the verdicts and the files."""

from __future__ import annotations

import base64
import tempfile
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from ...report import jpeg_bytes, plain, render_thesis_page, timeline_svg
from ..bench.bench_run import examined
from ..sweep import ExperimentResult, Result, SweepCase, Swept, experiment
from . import experiment as thesis
from .run_figures import FACTS, SPECK_PX, Looked, Thoroughness, beyond, look, stream

PAGE, DATA = FILES = ("thesis.html", "results.json")
_PAGE_WIDTH = 560
PICTURE, TRUTH, TIMELINE = "shown.jpg", "truth.jpg", "timeline.svg"
# What the published ratings of a part and latency say: the study package's, handed in.
Ratings = Callable[[str, float], thesis.Figures]
Progress = Callable[[int, int], None]
Say = Callable[[str], None]


def run_thesis(
    options: thesis.ThesisOptions,
    ratings: Ratings,
    progress: Progress = lambda done, total: None,
    say: Say = lambda text: None,
) -> ExperimentResult:
    """Run the experiments and write the page and results.json into options.out.

    Each run is a case. ratings: what the published ratings say; a function of a module, as it
    crosses to other machines by pickle. progress(done, total): in runs. say: gets a sentence.
    Errors: InputError, MachineError; that of the run where none of several was done.
    """
    chosen = list(thesis.experiments_named(options.only))
    if options.quick:  # the middle speed of each motion
        middle = [tuple(cell for cell in each.cells if all(map(thesis.is_quick, cell.runs))) for each in chosen]
        chosen = [attrs.evolve(each, cells=cells or each.cells) for each, cells in zip(chosen, middle, strict=True)]
    how = Thoroughness(options.eye_size, *((1, 2, thesis.QUICK_SCALE, 0.25) if options.quick else (3, 5)))
    runs = tuple(dict.fromkeys(run for each in chosen for run in each.runs()))
    # Of any experiment, not only of those chosen: what is kept serves another choice too.
    pictured: set[thesis.Run] = {run for each in thesis.experiments() for run in each.pictures}
    cases = cases_of(runs, pictured, how)

    work = partial(thesis_work, runs, ratings)
    with experiment(options, FILES, work, cases, progress, say) as (out, swept, described):
        made_on = swept.rows(lambda data: (data,))[0]
        figures = figures_by_run(swept.results())
        judged = [judge(each, figures) for each in chosen]
        counts = Counter(each["verdict"] for each in judged)
        data = described(
            {
                **{key: made_on[key] for key in ("machine", "clock")},
                "size": list(options.eye_size),
                "quick": options.quick,
                "verdicts": {verdict.value: counts[verdict.value] for verdict in thesis.Verdict},
                "experiments": judged,
                "failed": [f"{failure.name}: {failure.why}" for failure in swept.failed],
            }
        )
        out.write_text(PAGE, render_thesis_page(data, _pictures(chosen, swept)))
        out.write_json(DATA, data)
    return ExperimentResult(options.out, data, options.out / PAGE, swept)


@attrs.frozen
class _ThesisPart:
    """What one case runs."""

    run: thesis.Run
    how: Thoroughness
    # Whether its pictures, or the time line of its frames, are kept.
    is_pictured: bool


def cases_of(runs: Sequence[thesis.Run], pictured: set[thesis.Run], how: Thoroughness) -> list[SweepCase]:
    """Return a case for each run; pictured: whose pictures are kept."""
    cases = []
    for run in runs:
        group = ""
        if isinstance(run, thesis.PictureRun):  # what is timed is compared with each other
            group = "timed" if run.timed else repr(run.shared)
        cases.append(SweepCase.of("thesis", str(run), _ThesisPart(run, how, run in pictured), group=group))
    places: dict[Any, int] = {}
    for case in cases:
        for key in (case.group, _frames(case.what.run)):
            places.setdefault(key, len(places))
    return sorted(cases, key=lambda case: (places[case.group], places[_frames(case.what.run)]))


def _frames(run: thesis.Run) -> Any:
    return (run.timed, run.shared) if isinstance(run, thesis.PictureRun) else run


@contextmanager
def thesis_work(
    runs: Sequence[thesis.Run], ratings: Ratings
) -> Iterator[Callable[[SweepCase, Callable[[float], None]], Result]]:
    """Open a folder for the traces of heads, for what runs a case.

    runs: all that are chosen; those on the same frames are looked at together.
    """
    looked: dict[thesis.Run, Looked] = {}  # what waits for its turn

    def look_at(run: thesis.PictureRun, how: Thoroughness, folder: Path) -> Looked:
        if run not in looked:
            of_pictures = (each for each in runs if isinstance(each, thesis.PictureRun))
            together = [each for each in of_pictures if _frames(each) == _frames(run)]
            try:
                found = [*look(together, how, folder)]
            except Exception:
                if len(together) == 1:
                    raise
                found = [*look([run], how, folder)]  # one of them is at fault: the others go on
            looked.clear()
            looked.update({each.run: each for each in found})
        return looked[run]

    def runner(case: SweepCase, step: Callable[[float], None]) -> Result:
        part: _ThesisPart = case.what
        run, files = part.run, dict[str, bytes]()
        about = {key: examined()[0][key] for key in ("machine", "clock")}
        if isinstance(run, thesis.PictureRun):
            found = look_at(run, part.how, folder)
            figures = found.figures
            if run.timed and about["clock"] == "gpu":
                (least,) = look([attrs.evolve(run, scale=SPECK_PX / part.how.size[0])], part.how, folder)
                figures = beyond(figures, least.figures)
            if part.is_pictured:
                files = {PICTURE: jpeg_bytes(found.picture), TRUTH: jpeg_bytes(found.truth)}
        elif isinstance(run, thesis.StreamRun):
            figures, timeline = stream(run, part.how.stream_scale, part.how.stream_s)
            if part.is_pictured:
                files = {TIMELINE: timeline_svg(timeline).encode()}
        elif isinstance(run, thesis.RatingsRun):
            figures = ratings(run.part, run.latency_ms)
        else:
            figures = {"value": FACTS[run.fact]()}
        return Result({**about, "figures": figures}, files)

    with tempfile.TemporaryDirectory(prefix="hmdwarp-thesis-") as name:
        folder = Path(name)
        yield runner


def figures_by_run(results: Iterable[tuple[SweepCase, Mapping[str, Any]]]) -> dict[thesis.Run, thesis.Figures]:
    """Return the figures of every run; times of another machine than the first's are left out."""
    found: dict[thesis.Run, thesis.Figures] = {}
    timed_on: Any = None
    for case, data in results:
        run, figures = case.what.run, data["figures"]
        if isinstance(run, thesis.PictureRun) and run.timed:
            timed_on = timed_on or data["machine"]
            if data["machine"] != timed_on:
                figures = {name: value for name, value in figures.items() if not name.endswith("_ms")}
        found[run] = figures
    return found


def judge(experiment: thesis.Experiment, figures: Mapping[thesis.Run, thesis.Figures]) -> dict[str, Any]:
    """Return an experiment as plain data, with the number of each cell and the verdict."""
    findings = []
    for cell in experiment.cells:
        known = [figures[run] for run in cell.runs if run in figures]
        value = thesis.number_of(cell.computed, known) if len(known) == len(cell.runs) else None
        findings.append(thesis.Finding.of(cell.row, cell.column, value, experiment.rule))
    same = ("name", "source", "claim", "thesis", "measured", "unit", "digits", "scale", "weak")
    values = sorted(finding.value * experiment.scale for finding in findings if finding.value is not None)
    ends = dict.fromkeys(plain(value, experiment.digits) for value in (*values[:1], *values[-1:]))
    return {
        **{name: getattr(experiment, name) for name in same},
        "rule": f"{experiment.measured}: {experiment.rule.words(experiment.unit, experiment.scale)}",
        "ours": f"{' to '.join(ends)} {experiment.unit}".strip() if values else "",
        "verdict": thesis.verdict_of(findings).value,
        "holds_at": thesis.share_text(findings, True),
        "fails_at": thesis.share_text(findings, False),
        "unknown_at": thesis.settings_text(findings, None),
        "note": experiment.note,
        "cells": [attrs.asdict(finding) for finding in findings],
    }


def _pictures(chosen: Sequence[thesis.Experiment], swept: Swept) -> dict[str, list[tuple[str, str]]]:
    """Return (caption, data URI or <svg> element) of each experiment's pictures, by its name."""
    from PIL import Image

    done = {case.what.run: case.identity for case in swept.done}

    def file(run: thesis.Run, name: str) -> Path:
        return swept.kept.file(done[run], name)

    def uri(run: thesis.Run, name: str) -> str:
        picture = Image.open(file(run, name))
        picture.thumbnail((_PAGE_WIDTH, _PAGE_WIDTH), Image.Resampling.LANCZOS)
        return f"data:image/jpeg;base64,{base64.b64encode(jpeg_bytes(np.asarray(picture))).decode()}"

    found: dict[str, list[tuple[str, str]]] = {}
    for each in chosen:
        known = [run for run in each.pictures if run in done]
        pictures = [run for run in known if isinstance(run, thesis.PictureRun)]
        truths = {(run.scene, run.motion): run for run in pictures}.values()
        found[each.name] = [
            *((str(run), uri(run, PICTURE)) for run in pictures),
            *((f"what should be seen: {run.motion}", uri(run, TRUTH)) for run in truths),
            *(
                (f"way of the last frames: {run}", file(run, TIMELINE).read_text("utf-8"))
                for run in known
                if isinstance(run, thesis.StreamRun)
            ),
        ]
    return found
