"""Sets of cases: each is run here or on a Dask cluster, and kept as soon as it is done."""

from __future__ import annotations

import asyncio
import concurrent.futures
import itertools
import logging
import os
import re
import socket
import threading
import time
import traceback
import uuid
from collections import deque
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import Any

import attrs

from ...base import HmdwarpError, InputError, MachineError, __version__, import_extra, lock
from ...base.documents import json_in
from ...base.identity import identity_of, program_hash
from ...base.named_files import RESULTS
from ...gpu.context import contexts_kept
from ...metrics import MeasuringThreads, worker_count
from ...report import SCHEMA, OutputFolder, write_bytes, write_json
from ...report.bench.rows import Column, table_of
from .options import LOCAL, ClusterOptions, ExperimentOptions, KeptOptions

FOLDER = "cases"
DONE, FAILED = "done", "failed"


@attrs.frozen
class Result:
    """What a case gave."""

    # As JSON has it.
    data: Any
    # Further files by name, such as pictures.
    files: Mapping[str, bytes] = attrs.field(factory=dict)


@attrs.frozen
class Failure:
    """Why a case gave no result."""

    name: str
    why: str
    # The command's, if this is all that went wrong.
    exit_status: int = HmdwarpError.exit_status
    # Python's own report, for faults of the program.
    traceback: str = ""

    @classmethod
    def of(cls, name: str, error: Exception) -> Failure:
        """Return the failure that an exception of a case is."""
        if isinstance(error, HmdwarpError):
            return cls(name, str(error), error.exit_status)
        if isinstance(error, OSError):
            return cls(name, str(error), MachineError.exit_status)
        lines = "".join(traceback.format_exception(error))
        why = f"a fault of hmdwarp, please report it: {type(error).__name__}: {error}"
        return cls(name, why, traceback=lines)


@attrs.frozen
class KeptCases:
    """The folder of a run's cases: one JSON file for each that is done or failed, written last."""

    folder: Path

    def read(self, identity: str) -> dict[str, Any]:
        """Return what is kept of a case, nothing of one that was not run to its end."""
        with suppress(InputError):
            data = json_in(self._path(identity), RESULTS)
            if isinstance(data, dict) and data.get("identity") == identity:
                return data
        return {}

    def state(self, identity: str) -> str:
        """Return DONE, FAILED, or "" for what was not run to its end."""
        return str(self.read(identity).get("state", ""))

    def result(self, identity: str) -> Any:
        """Return the data of a case that is done. Errors: HmdwarpError if it is not."""
        data = self.read(identity)
        if data.get("state") != DONE:
            raise HmdwarpError(f"{self._path(identity)}: no result of a case: run it again with --resume")
        return data["result"]

    def keep(self, identity: str, name: str, result: Result) -> None:
        """Write a result. Errors: InputError or MachineError for a place that cannot be written."""
        self._path(identity).unlink(missing_ok=True)  # its files are of one run
        self.folder.mkdir(parents=True, exist_ok=True)
        for file, content in result.files.items():
            write_bytes(self.file(identity, file), content)
        self._write(identity, {"state": DONE, "name": name, "result": result.data})

    def keep_failure(self, identity: str, failure: Failure) -> None:
        """Write why a case failed. Errors: as keep."""
        self._write(identity, {"state": FAILED, **attrs.asdict(failure)})

    def file(self, identity: str, name: str) -> Path:
        return self.folder / f"{identity}-{name}"

    def clear(self, stay: Collection[str]) -> None:
        for path in self.folder.glob("*"):
            identity = path.name.partition("-")[0].partition(".")[0]
            if len(identity) == 32 and identity not in stay and path.is_file():
                path.unlink()

    def _path(self, identity: str) -> Path:
        return self.folder / f"{identity}.json"

    def _write(self, identity: str, data: Mapping[str, Any]) -> None:
        self.folder.mkdir(parents=True, exist_ok=True)
        write_json(self._path(identity), {"identity": identity, **data})


@contextmanager
def held(folder: Path) -> Iterator[None]:
    """Keep other runs out of a folder. Errors: MachineError that says who holds it since when."""
    path, is_there = folder / ".lock", False
    while not is_there:
        file = os.open(path, os.O_RDWR | os.O_CREAT, 0o600)
        try:
            lock(file)
            is_there = path.exists() and os.path.samestat(os.fstat(file), path.stat())
        except BlockingIOError as error:
            holder = os.read(file, 500).decode(errors="replace").strip()
            os.close(file)
            raise MachineError(
                f"{folder}: another run writes here ({holder}): end it first, wait, or take another folder"
            ) from error
        except OSError:  # a file system that locks nothing
            is_there = True
        if not is_there:
            os.close(file)  # its holder has just deleted it
    try:
        now = datetime.now().astimezone()
        os.ftruncate(file, 0)  # what one that was killed has written
        os.write(file, f"since {now:%H:%M on %Y-%m-%d}, process {os.getpid()} on {socket.gethostname()}".encode())
        yield
    finally:
        path.unlink(missing_ok=True)
        os.close(file)


Row = dict[str, Any]
Say = Callable[[str], None]
# Takes the share of a case that is done, from 0 to 1.
Step = Callable[[float], None]


@attrs.frozen
class SweepCase:
    """One case: what is run, kept and run again by itself."""

    # For people, such as "walk, 200 ms".
    name: str
    # What its Work runs: options and plain values, which cross to other machines by pickle.
    what: Any = attrs.field(repr=False)
    identity: str
    # Cases that follow each other with the same group run on one machine, one after the other, so
    # that their times can be compared.
    group: str = ""
    # Its share of the progress.
    steps: int = 1
    # What the identity is of besides.
    kind: str = ""

    @classmethod
    def of(cls, kind: str, name: str, what: Any, **about: Any) -> SweepCase:
        """Return a case with its identity. Errors: InputError for a file that cannot be read."""
        try:
            return cls(name, what, identity_of(kind, what), kind=kind, **about)
        except OSError as error:
            raise InputError(f"{error.filename}: cannot read ({error.strerror}): {name} is made with it") from error

    @property
    def is_here(self) -> bool:
        """Whether the files of its options are the same on this machine."""
        return self.identity == identity_of(self.kind, self.what)


# Runs a case and returns its result.
Runner = Callable[[SweepCase, Step], Result]


# Opens what cases share, for the runner of each. It crosses to other machines by pickle.
Work = Callable[[], AbstractContextManager[Runner]]


def sharing_nothing(run: Runner) -> Work:
    return partial(nullcontext, run)  # type: ignore[return-value]


@contextmanager
def with_threads(run: Callable[[MeasuringThreads, SweepCase, Step], Result], workers: int | None) -> Iterator[Runner]:
    """Open the threads in which cases measure pictures. workers: as the option."""
    with MeasuringThreads(worker_count(workers)) as threads:
        yield partial(run, threads)


def _run_group(runner: Runner, cases: Sequence[SweepCase], step: Step) -> Iterator[tuple[SweepCase, Result | Failure]]:
    """Run cases of one group; yield each as it is done, those that failed with the reason."""
    for case in cases:
        try:
            outcome: Result | Failure = runner(case, step)
        except Exception as error:
            outcome = Failure.of(case.name, error)
        yield case, outcome


def _groups_of(cases: Sequence[SweepCase]) -> list[list[SweepCase]]:
    """Return cases that follow each other in one group together; each without a group by itself."""
    return [list(group) for _, group in itertools.groupby(cases, key=lambda case: case.group or case.identity)]


RUN_AGAIN = 2  # times that a case is run again because its worker died
CONNECT_S = 30.0
Outcome = tuple[SweepCase, Result | Failure]
_one_at_a_time = threading.Lock()


def run_on_cluster(work: Work, cases: Sequence[SweepCase], cluster: str, say: Say) -> Iterator[Outcome]:
    """Yield each case with its result or failure as it comes back.

    Errors: MachineError for a cluster that cannot be reached, is lost, or has another program.
    """
    distributed: Any = import_extra("distributed", "dask.distributed", "cluster")
    for name in [*logging.root.manager.loggerDict]:
        if name.partition(".")[0] == "distributed":
            log = logging.getLogger(name)
            log.handlers, log.propagate = [logging.NullHandler()], False
    with _connected(distributed, cluster, say) as client:
        sent: dict[Any, list[SweepCase]] = {}  # what is under way
        token, waiting = uuid.uuid4().hex[:8], deque(_groups_of(cases))

        def send() -> Any:
            group = waiting.popleft()
            key = f"hmdwarp-{group[0].identity}-{token}"
            future = client.submit(run_here, work, group, program_hash(()), Path.cwd(), key=key, pure=False)
            sent[future] = group
            return future

        # Groups sent and not back: one for each worker here, as what waits on a worker counts as
        # run there when that dies of another. A scheduler elsewhere gets all: it may start workers.
        local = re.fullmatch(LOCAL, cluster)
        ahead = int(local[1]) if local else len(waiting)
        completed = distributed.as_completed([send() for _ in range(min(ahead, len(waiting)))], loop=client.loop)
        try:
            for future in completed:
                if future.status in ("pending", "lost"):  # its worker died with the result: it is run again
                    completed.add(future)
                    continue
                yield from _outcomes(distributed, future, sent.pop(future), cluster)
                if waiting:
                    completed.add(send())
                future.release()
        except (OSError, asyncio.CancelledError, concurrent.futures.CancelledError) as error:
            raise _lost(cluster) from error
        finally:
            with suppress(Exception):  # of a scheduler that is gone
                client.cancel(list(sent))


def run_here(work: Work, cases: Sequence[SweepCase], program: str, folder: Path) -> list[tuple[str, Result | Failure]]:
    """Run a group of cases on a worker; return what became of each by its identity.

    folder: in which paths begin. Errors: MachineError for another program, or other files.
    """
    from distributed import get_worker

    if program_hash(()) != program:
        why = "has another hmdwarp than this machine: install the same wheel on both"
        raise MachineError(f"worker {get_worker().name} {why}")
    with _one_at_a_time, work() as runner:  # a worker may have several threads
        with suppress(OSError):  # then files are not found, or are others
            os.chdir(folder)
        if apart := [case.name for case in cases if not case.is_here]:
            why = "has not the same files under the names of"
            raise MachineError(f"worker {get_worker().name} {why} {apart[0]}: share their folder with all machines")
        return [(case.identity, outcome) for case, outcome in _run_group(runner, cases, lambda share: None)]


def _outcomes(distributed: Any, future: Any, group: Sequence[SweepCase], cluster: str) -> Iterator[Outcome]:
    if future.status == "cancelled":
        raise _lost(cluster)
    if future.status == "finished":
        by_identity = dict(future.result())
        yield from ((case, by_identity[case.identity]) for case in group)
        return
    error = future.exception()
    if isinstance(error, distributed.scheduler.KilledWorker):
        why = f"its worker died, and {RUN_AGAIN} more that ran it again: too little memory, or a driver that crashes"
        error = MachineError(why)
    elif not isinstance(error, HmdwarpError):
        error = MachineError(f"a worker could not run it ({type(error).__name__}: {error})")
    yield from ((case, Failure.of(case.name, error)) for case in group)


def _lost(cluster: str) -> MachineError:
    return MachineError(
        f"--cluster {cluster}: the scheduler is gone; what was done is kept: start it, and run this again with --resume"
    )


@contextmanager
def _connected(distributed: Any, cluster: str, say: Say) -> Iterator[Any]:
    """Connect to the scheduler at an address, or start one with workers on this machine."""
    import dask

    local = re.fullmatch(LOCAL, cluster)
    made: Any = cluster
    with dask.config.set({"distributed.scheduler.allowed-failures": RUN_AGAIN}):
        if local:
            at = {"host": "127.0.0.1", "dashboard_address": "127.0.0.1:0", "silence_logs": logging.CRITICAL}
            made = distributed.LocalCluster(n_workers=int(local[1]), threads_per_worker=1, **at)
        try:
            client = distributed.Client(made, timeout=CONNECT_S, set_as_default=False)
        except (OSError, ValueError) as error:
            raise MachineError(
                f"--cluster {cluster}: no Dask scheduler there ({error}): expected local:N, or the address that "
                "'dask scheduler' prints, such as tcp://10.0.0.1:8786"
            ) from error
    try:
        say(f"dashboard: {client.dashboard_link}")
        yield client
    finally:
        client.close()
        if local:
            made.close()


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
        return (case for case in self.cases if self.kept.state(case.identity) == DONE)

    def results(self) -> Iterator[tuple[SweepCase, Any]]:
        """Read the results of the cases that are done from the disk, in their order."""
        return ((case, self.kept.result(case.identity)) for case in self.done)

    def raise_failures(self) -> None:
        raise_failed(self.failed, len(self.cases), "the others are kept: run it again with --resume")

    def rows(self, rows_of: Callable[[Any], Sequence[Row]]) -> list[Row]:
        """Return the rows of all cases that are done; raise failures if there are none."""
        rows = [row for _, result in self.results() for row in rows_of(result)]
        if not rows:
            self.raise_failures()
        return rows


@attrs.frozen(eq=False)
class ExperimentResult:
    """What was found, and where it lies."""

    folder: Path
    # As in the JSON file there.
    data: dict[str, Any]
    # The page.
    report: Path
    # The cases that were run, and which failed. None if merged.
    swept: Swept | None = None
    # Of the rows in `data`, those that a notebook shows.
    columns: tuple[Column, ...] = ()

    def __repr__(self) -> str:
        failed = 0 if self.swept is None else len(self.swept.failed)
        return f"<ExperimentResult: {len(self.data.get('rows', ()))} rows, {failed} cases failed; {self.report}>"

    def _repr_html_(self) -> str | None:
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
    resume. Errors: InputError or MachineError for a folder that cannot be written.
    """
    kept = KeptCases(out / FOLDER)
    missing = [case for case in cases if not options.resume or kept.state(case.identity) != DONE]
    known = len(cases) - len(missing)
    if known:
        say(f"{known} of {len(cases)} cases are kept from before in {kept.folder}")
    steps = sum(case.steps for case in cases) - sum(case.steps for case in missing)
    for case, outcome in outcomes(work, missing, options, progress, say, known=steps):
        if isinstance(outcome, Failure):
            kept.keep_failure(case.identity, outcome)
            say(f"failed: {case.name}: {outcome.why}")
        else:
            kept.keep(case.identity, case.name, outcome)
    if not options.resume:
        kept.clear({case.identity for case in cases})
    names = [field.name for field in attrs.fields(Failure)]
    wrong = [data for case in cases if (data := kept.read(case.identity)).get("state") == FAILED]
    failed = tuple(Failure(**{name: data[name] for name in names if name in data}) for data in wrong)
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
    what was found, and what every experiment has. Errors: as OutputFolder and held.
    """
    started_s = time.perf_counter()

    def described(found: Mapping[str, Any]) -> dict[str, Any]:
        about = {"schema": SCHEMA, "hmdwarp": __version__, "command": options.command}
        return {**about, **found, "seconds": time.perf_counter() - started_s}

    with OutputFolder(options.out, owned=files[:-1], last=files[-1], force=options.force) as out, held(options.out):
        yield out, run_cases(work, cases, options.out, options.sweep, progress, say), described


def outcomes(
    work: Work,
    cases: Sequence[SweepCase],
    options: ClusterOptions,
    progress: Progress,
    say: Say,
    *,
    known: int = 0,
) -> Iterator[Outcome]:
    """Run all of the cases, here or on a cluster, and yield what became of each.

    progress(done, total): in steps of the cases. known: steps that were done before.
    """
    waiting = [case.steps for case in cases]
    total, done, shown = known + sum(waiting), known, -1

    def show(now: int) -> None:
        nonlocal shown
        if now > shown:
            shown = now
            progress(now, total)

    def within(share: float) -> None:
        if waiting:
            show(done + round(share * waiting[0] - 0.5 + 1e-6))

    def here() -> Iterator[Outcome]:
        with contexts_kept(), work() as runner:
            for group in _groups_of(cases):
                yield from _run_group(runner, group, within)

    show(done)
    if not cases:
        return
    there = options.cluster
    for case, outcome in here() if there is None else run_on_cluster(work, cases, there, say):
        yield case, outcome
        done += case.steps
        del waiting[0]
        show(done)


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
