"""One case of a set, and its result, which is kept on disk under the hash of what made it.

The same hash is the same result, but for times. Each result is written whole: what is done stays
done.
"""

from __future__ import annotations

import bisect
import itertools
import os
import platform
import socket
import traceback
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from datetime import datetime
from pathlib import Path
from typing import Any, Protocol, overload

import attrs

from ...errors import HmdwarpError, InputError, MachineError
from ...metrics import MeasuringProcesses, worker_count
from ...options.documents import json_in
from ...options.identity import identity_of
from ...options.named_files import RESULTS
from ...platforms import lock
from ...report import write_bytes, write_json

FOLDER = "cases"
DONE, FAILED = "done", "failed"


@attrs.frozen
class Result:
    """What a case gave."""

    # As JSON has it.
    data: Any
    # Further files by name, such as pictures.
    files: Mapping[str, bytes] = attrs.field(factory=dict)
    # Of the machine and process that ran it, for a person.
    where: str = ""


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
    """The folder of a run's cases: one JSON file for each that is done or failed.

    The file is written last and at once, so that a case with further files is whole or not there.
    """

    folder: Path

    def state(self, identity: str) -> str:
        """Return DONE, FAILED, or "" for what was not run to its end."""
        return str((self._read(identity) or {}).get("state", ""))

    def result(self, identity: str) -> Any:
        """Return the data of a case that is done. Errors: HmdwarpError if it is not."""
        data = self._read(identity)
        if data is None or data.get("state") != DONE:
            raise HmdwarpError(f"{self._path(identity)}: no result of a case: run it again with --resume")
        return data["result"]

    def failure(self, identity: str) -> Failure:
        """Return why a case failed."""
        data = self._read(identity) or {}
        return Failure(**{each.name: data[each.name] for each in attrs.fields(Failure) if each.name in data})

    def keep(self, identity: str, name: str, result: Result) -> None:
        """Write a result. Errors: InputError or MachineError for a place that cannot be written."""
        self.folder.mkdir(parents=True, exist_ok=True)
        self._path(identity).unlink(missing_ok=True)  # its files are of one run
        for file, content in result.files.items():
            write_bytes(self.file(identity, file), content)
        self._write(identity, {"state": DONE, "name": name, "where": result.where, "result": result.data})

    def keep_failure(self, identity: str, failure: Failure) -> None:
        """Write why a case failed. Errors: as keep."""
        self.folder.mkdir(parents=True, exist_ok=True)
        self._write(identity, {"state": FAILED, **attrs.asdict(failure)})

    def file(self, identity: str, name: str) -> Path:
        """Return the path of a file that belongs to a case."""
        return self.folder / f"{identity}-{name}"

    def clear(self, stay: Collection[str]) -> None:
        """Delete all cases but these."""
        for path in self.folder.glob("*"):
            identity = path.name.partition("-")[0].partition(".")[0]
            if len(identity) == 32 and identity not in stay and path.is_file():
                path.unlink()

    def _path(self, identity: str) -> Path:
        return self.folder / f"{identity}.json"

    def _write(self, identity: str, data: Mapping[str, Any]) -> None:
        write_json(self._path(identity), {"identity": identity, **data})

    def _read(self, identity: str) -> dict[str, Any] | None:
        with suppress(InputError):
            data = json_in(self._path(identity), RESULTS)
            if isinstance(data, dict) and data.get("identity") == identity:
                return data
        return None


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
# The rows in the result of a case; a case may have none.
RowsOf = Callable[[Any], Sequence[Row]]


class KeptRows(Sequence[Row]):
    """The rows of cases that are done, case by case; each is read when it is asked for."""

    def __init__(self, kept: KeptCases, identities: Sequence[str], rows_of: RowsOf) -> None:
        self._kept, self._rows_of = kept, rows_of
        counts = {identity: len(self._read(identity)) for identity in identities}
        self._identities = [identity for identity, count in counts.items() if count]
        # The number of the first row after each of these cases.
        self._ends = list(itertools.accumulate(counts[identity] for identity in self._identities))

    def __len__(self) -> int:
        return self._ends[-1] if self._ends else 0

    def __iter__(self) -> Iterator[Row]:
        for identity in self._identities:
            yield from self._read(identity)

    @overload
    def __getitem__(self, at: int) -> Row: ...
    @overload
    def __getitem__(self, at: slice) -> list[Row]: ...
    def __getitem__(self, at: int | slice) -> Row | list[Row]:
        if isinstance(at, slice):
            return [self[number] for number in range(*at.indices(len(self)))]
        number = range(len(self))[at]
        case = bisect.bisect_right(self._ends, number)
        return self._read(self._identities[case])[number - self._ends[case]]

    def _read(self, identity: str) -> Sequence[Row]:
        return self._rows_of(self._kept.result(identity))


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

    @classmethod
    def of(cls, kind: str, name: str, what: Any, also: Sequence[str] = (), **about: Any) -> SweepCase:
        """Return a case with its identity.

        also: parts of the program that it depends on, as program_hash. Errors: InputError for a
        file that cannot be read.
        """
        try:
            return cls(name, what, identity_of(kind, what, also), **about)
        except OSError as error:
            raise InputError(f"{error.filename}: cannot read ({error.strerror}): {name} is made with it") from error


# Runs a case and returns its result.
Runner = Callable[[SweepCase, Step], Result]


class Work(Protocol):
    """How the cases of a command are run. It crosses to other machines by pickle."""

    def opened(self) -> AbstractContextManager[Runner]:
        """Open what cases share, such as measuring processes."""
        ...


@attrs.frozen
class Separate:
    """A Work whose cases share nothing."""

    run: Runner

    def opened(self) -> AbstractContextManager[Runner]:
        """Open nothing."""
        return nullcontext(self.run)


@attrs.frozen
class Measuring:
    """A Work whose cases measure pictures in the same other processes."""

    run: Callable[[MeasuringProcesses, SweepCase, Step], Result]
    workers: int | None  # as the option

    @contextmanager
    def opened(self) -> Iterator[Runner]:
        """Open the measuring processes; what failed is not measured any further."""
        with MeasuringProcesses(worker_count(self.workers)) as processes:

            def runner(case: SweepCase, step: Step) -> Result:
                try:
                    return self.run(processes, case, step)
                except BaseException:
                    processes.close()
                    raise

            yield runner


def run_group(runner: Runner, cases: Sequence[SweepCase], step: Step) -> Iterator[tuple[SweepCase, Result | Failure]]:
    """Run cases of one group; yield each as it is done, those that failed with the reason."""
    for case in cases:
        try:
            outcome: Result | Failure = attrs.evolve(runner(case, step), where=platform.node())
        except Exception as error:
            outcome = Failure.of(case.name, error)
        yield case, outcome


def groups_of(cases: Sequence[SweepCase]) -> list[list[SweepCase]]:
    """Return cases that follow each other in one group together; each without a group by itself."""
    return [list(group) for _, group in itertools.groupby(cases, key=lambda case: case.group or case.identity)]
