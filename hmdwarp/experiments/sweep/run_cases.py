"""Runs a set of cases, one after the other here; each is kept as soon as it is done."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import attrs

from ...errors import HmdwarpError, InputError, MachineError
from ...gpu.context import contexts_kept
from ...report import SCHEMA, OutputFolder
from ...report.bench.rows import Column, table_of
from ...resources import __version__
from .cluster import run_on_cluster
from .options import ClusterOptions, ExperimentOptions, KeptOptions
from .sweep_case import (
    DONE,
    FAILED,
    FOLDER,
    Failure,
    KeptCases,
    KeptRows,
    Result,
    RowsOf,
    Say,
    SweepCase,
    Work,
    groups_of,
    held,
    run_group,
)

Progress = Callable[[int, int], None]
# Cases on a page, which draws charts of each: a second for two.
MOST_SHOWN = 40


@attrs.frozen
class Swept:
    """What became of a set of cases."""

    kept: KeptCases
    cases: tuple[SweepCase, ...]
    failed: tuple[Failure, ...]
    # Those that an earlier run had done.
    known: int

    @property
    def done(self) -> Iterator[SweepCase]:
        """The cases that are done, in the order of the cases."""
        return (case for case in self.cases if self.kept.state(case.identity) == DONE)

    def results(self) -> Iterator[tuple[SweepCase, Any]]:
        """Read the results of the cases that are done from the disk, in the order of the cases."""
        return ((case, self.kept.result(case.identity)) for case in self.done)

    def raise_failures(self) -> None:
        """Raise the error of a run in which cases failed: see raise_failed."""
        raise_failed(self.failed, len(self.cases), "the others are kept: run it again with --resume")

    def rows(self, rows_of: RowsOf) -> KeptRows:
        """Return the rows of all cases that are done, which stay on the disk.

        Errors: as raise_failures, where there are none.
        """
        rows = KeptRows(self.kept, [case.identity for case in self.done], rows_of)
        if not rows:
            self.raise_failures()
        return rows


@attrs.frozen(eq=False)
class ExperimentResult:
    """What was found, and where it lies."""

    folder: Path
    # As in the JSON file there; rows are read from the disk, until the next run in the folder.
    data: dict[str, Any]
    # The page.
    report: Path
    # The cases that were run, and which failed. None if merged.
    swept: Swept | None = None
    # Why no result fits the options, else "".
    refused: str = ""
    # Of the rows in `data`, those that a notebook shows.
    columns: tuple[Column, ...] = ()

    def __repr__(self) -> str:
        failed = 0 if self.swept is None else len(self.swept.failed)
        return f"<ExperimentResult: {len(self.data.get('rows', ()))} rows, {failed} cases failed; {self.report}>"

    def _repr_html_(self) -> str | None:
        """Return a table of the first rows: a notebook shows it."""
        rows = itertools.islice(self.data.get("rows", ()), MOST_SHOWN)
        return table_of("", self.columns, rows).html() if self.columns else None

    def raise_failures(self) -> None:
        """Raise the error of a run in which cases failed: see raise_failed."""
        if self.swept is not None:
            self.swept.raise_failures()


def run_cases(
    work: Work,
    cases: Sequence[SweepCase],
    out: Path,
    options: KeptOptions,
    progress: Progress = lambda done, total: None,
    say: Say = lambda text: None,
) -> Swept:
    """Run the cases that are not done and keep each in the folder `cases` of `out`.

    A case that fails is kept as failed, and the others go on. An interruption leaves what is done,
    and what an earlier run kept: that of other cases is deleted at the end of one that does not
    resume.
    progress(done, total): in steps of the cases. say: gets a sentence.
    Errors: InputError or MachineError for a folder that cannot be written.
    """
    kept = KeptCases(out / FOLDER)
    missing = [case for case in cases if not options.resume or kept.state(case.identity) != DONE]
    known = len(cases) - len(missing)
    if known:
        say(f"{known} of {len(cases)} cases are kept from before in {kept.folder}")
    bar = _Bar(cases, missing, progress)
    for case, outcome in _run(work, missing, options, bar, say, in_turn=options.in_turn):
        if isinstance(outcome, Failure):
            kept.keep_failure(case.identity, outcome)
            say(f"failed: {case.name}: {outcome.why}")
        else:
            kept.keep(case.identity, case.name, outcome)
        bar.done(case)
    if not options.resume:
        kept.clear({case.identity for case in cases})
    failed = tuple(kept.failure(case.identity) for case in cases if kept.state(case.identity) == FAILED)
    return Swept(kept, tuple(cases), failed, known)


@contextmanager
def experiment(
    options: ExperimentOptions,
    files: tuple[str, ...],
    work: Work,
    cases: Sequence[SweepCase],
    progress: Progress,
    say: Say,
) -> Iterator[tuple[OutputFolder, Swept, Callable[[Mapping[str, Any]], dict[str, Any]]]]:
    """Run the cases; the block writes the files, which replace those of an earlier run at its end.

    files: that it may write, the JSON file last. The third value returns the content of that file:
    what was found, and what every experiment has. progress(done, total): in steps of the cases.
    say: gets a sentence. Errors: as OutputFolder and held.
    """
    started_s = time.perf_counter()

    def described(found: Mapping[str, Any]) -> dict[str, Any]:
        about = {"schema": SCHEMA, "hmdwarp": __version__, "command": options.command}
        return {**about, **found, "seconds": time.perf_counter() - started_s}

    with OutputFolder(options.out, owned=files[:-1], last=files[-1], force=options.force) as out, held(options.out):
        yield out, run_cases(work, cases, options.out, options.sweep, progress, say), described


def outcomes(
    work: Work, cases: Sequence[SweepCase], options: ClusterOptions, progress: Progress, say: Say
) -> Iterator[tuple[SweepCase, Result | Failure]]:
    """Run all of the cases and yield what became of each, for those who keep results themselves."""
    bar = _Bar(cases, cases, progress)
    for case, outcome in _run(work, cases, options, bar, say):
        yield case, outcome
        bar.done(case)


def raise_failed(failed: Sequence[Failure], count: int, then: str) -> None:
    """Raise the error of `count` cases of which some failed, with the exit status of the first.

    then: what to do. Errors: InputError, MachineError or HmdwarpError.
    """
    if not failed:
        return
    first = failed[0]
    kind = next((each for each in (InputError, MachineError) if each.exit_status == first.exit_status), HmdwarpError)
    if count == 1:
        raise kind(first.why)
    others = f", and {len(failed) - 1} more" if len(failed) > 1 else ""
    raise kind(f"{len(failed)} of {count} cases failed: {first.name}: {first.why}{others}; {then}")


def _run(
    work: Work, cases: Sequence[SweepCase], options: ClusterOptions, bar: _Bar, say: Say, *, in_turn: bool = False
) -> Iterator[tuple[SweepCase, Result | Failure]]:
    """Yield what became of each case, here or on a cluster."""
    if not cases:
        return
    if options.cluster is not None:
        yield from run_on_cluster(work, cases, options.cluster, say, in_turn=in_turn)
        return
    with contexts_kept(), work.opened() as runner:
        for group in groups_of(cases):
            yield from run_group(runner, group, bar.within)


class _Bar:
    """One progress over cases of different lengths."""

    def __init__(self, cases: Sequence[SweepCase], missing: Sequence[SweepCase], progress: Progress) -> None:
        self._total, self._progress = sum(case.steps for case in cases), progress
        self._done = self._total - sum(case.steps for case in missing)
        self._shown, self._steps = -1, [case.steps for case in missing]
        self._show(self._done)

    def within(self, share: float) -> None:
        """Show the share of the present case that is done."""
        if self._steps:
            self._show(self._done + round(share * self._steps[0] - 0.5 + 1e-6))

    def done(self, case: SweepCase) -> None:
        """Show that a case is over."""
        self._done += case.steps
        self._steps = self._steps[1:]
        self._show(self._done)

    def _show(self, done: int) -> None:
        if done > self._shown:
            self._shown = done
            self._progress(done, self._total)
