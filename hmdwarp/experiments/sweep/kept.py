"""Results of single cases on disk, each written whole: what is done stays done."""

from __future__ import annotations

import bisect
import itertools
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, overload

import attrs

from ...errors import HmdwarpError, InputError, MachineError
from ...options.documents import json_in
from ...options.named_files import RESULTS
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

    def clear(self) -> None:
        """Delete all cases: a run that does not resume begins with none."""
        for path in self.folder.glob("*"):
            if len(path.name.partition("-")[0].partition(".")[0]) == 32 and path.is_file():
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
