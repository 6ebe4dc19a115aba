"""One case of a set, what it is made with as one hash, and its result, which is kept on disk.

The same hash is the same result, but for times. Each result is written whole: what is done stays
done.
"""

from __future__ import annotations

import bisect
import enum
import functools
import hashlib
import itertools
import json
import platform
import re
import traceback
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext, suppress
from pathlib import Path
from typing import Any, Protocol, overload
from urllib.parse import unquote

import attrs

from ...errors import HmdwarpError, InputError, MachineError
from ...options.declared import HOW
from ...options.documents import json_in
from ...options.named_files import BAG, BESIDE, GLTF, RESULTS, content_of, opened
from ...report import write_bytes, write_json
from ...resources import __version__
from ...resources import folder as resource_folder

# What neither draws nor measures a picture: a change there leaves most results as they are.
_NOT_OF_RESULTS = ("cli/", "display/", "report/", "study/", "experiments/sweep/", "experiments/thesis/")
# What begins the lines of a scene's files that name another file.
_NAMING = {".obj": "mtllib", ".mtl": "map_kd", ".ply": "comment texturefile"}
_CHUNK = 1 << 20


def identity_of(kind: str, what: Any, also: Sequence[str] = ()) -> str:
    """Return the hash of the program, of a kind of case, and of what it runs.

    what: options and plain values. A file counts by its name and content, not by its place. also:
    as program_hash.
    Errors: OSError and InputError for a file that cannot be read.
    """
    made_with = {"hmdwarp": __version__, "program": program_hash(*also), "kind": kind, "what": _content(what)}
    text = json.dumps(made_with, sort_keys=True, allow_nan=True)
    return hashlib.sha256(text.encode(errors="surrogatepass")).hexdigest()[:32]


@functools.cache
def program_hash(*also: str) -> str:
    """Return a hash of the program's files that results depend on, wherever it is installed.

    also: beginnings of paths in the package that this kind of results depends on besides what draws
    and measures pictures, such as `study/`.
    """
    package, shaders = Path(__file__).resolve().parents[2], resource_folder("shaders")
    found = hashlib.sha256()
    for base, pattern in ((package, "**/*.py"), (package, "**/*.toml"), (shaders, "**/*.*")):
        for path in sorted(base.glob(pattern)):
            name = path.relative_to(base).as_posix()
            counts = not name.startswith((*_NOT_OF_RESULTS, "_data/")) or name.startswith(also)
            if path.is_file() and counts:
                found.update(name.encode() + b"\0" + path.read_bytes())
    return found.hexdigest()[:16]


def whole_program_hash() -> str:
    """Return a hash of all files of the program: the same wheel has the same one."""
    return program_hash(*_NOT_OF_RESULTS)


def files_at(place: str | Path) -> list[Path]:
    """Return the files that a place stands for: one, those that a scene names, those of a folder.

    What a scene names outside its folder is left out.
    """
    path = Path(place)
    if path.is_dir():
        return sorted(each for each in path.rglob("*") if each.is_file())
    found = [path]
    for each in found:  # it grows: the materials of a scene name its pictures
        names = (name for name in _named_by(*_state(each)) if not {"..", "/"} & {*Path(name).parts})
        beside = dict.fromkeys(path.parent / name for name in names)
        found += [other for other in beside if other not in found and is_place(other) and other.is_file()]
    return sorted(found)


def _state(path: Path) -> tuple[Path, int, int]:
    """Return what changes with a file's content: so that no case reads it again."""
    about = path.stat()
    return path, about.st_size, about.st_mtime_ns


@functools.lru_cache(maxsize=256)
def _named_by(path: Path, size: int, mtime_ns: int) -> list[str]:
    """Return the names of files in a file of a scene, relative to the scene's folder."""
    kind, uris = path.suffix.lower(), list[Any]()
    if kind == ".gltf":
        with suppress(InputError, AttributeError, TypeError):  # loading the scene says what is wrong
            header = json_in(path, GLTF)
            uris = [one.get("uri") for part in ("buffers", "images") for one in header.get(part, [])]
        return [unquote(uri) for uri in uris if isinstance(uri, str) and not uri.startswith("data:")]
    if kind == ".xml":
        return re.findall(r'name="filename"\s+value="([^"]+)"', content_of(path, BESIDE).decode("utf-8", "replace"))
    if (begins := _NAMING.get(kind)) is None:
        return []
    lines = (line.strip() for line in content_of(path, BESIDE).decode("utf-8", "replace").splitlines())
    return [line[len(begins) :].strip() for line in lines if line[: len(begins)].lower() == begins]


def hash_of_files(place: str | Path) -> str:
    """Return a hash of the names and contents of files_at(place)."""
    path = Path(place)
    base = path if path.is_dir() else path.parent
    return _hash_of_files(tuple(map(_state, files_at(path))), base)


@functools.lru_cache(maxsize=256)
def _hash_of_files(files: tuple[tuple[Path, int, int], ...], base: Path) -> str:
    found = hashlib.sha256()
    for path, _, _ in files:
        found.update(path.relative_to(base).as_posix().encode(errors="surrogatepass") + b"\0")
        with opened(path, BAG) as stream:
            while chunk := stream.read(_CHUNK):
                found.update(chunk)
    return found.hexdigest()


def _content(value: Any) -> Any:
    """Return plain data of options and values, with files by content."""
    if attrs.has(type(value)):
        fields = {each.name: getattr(value, each.name) for each in attrs.fields(type(value)) if each.name not in HOW}
        return {"": type(value).__name__, **{name: _content(each) for name, each in fields.items()}}
    if isinstance(value, Mapping):
        return {str(key): _content(each) for key, each in value.items()}
    if isinstance(value, enum.Enum):
        return value.name
    if isinstance(value, str | Path):
        return _text(value)
    if isinstance(value, Iterable):
        return [_content(each) for each in value]
    return value if value is None or isinstance(value, bool | int | float) else repr(value)


def _text(value: str | Path) -> Any:
    path = Path(value)
    if is_place(value):
        return {"file": path.name, "content": hash_of_files(path)}
    return str(value)


def is_place(value: str | Path) -> bool:
    """Return whether a text names a file, or a path a file or folder.

    A bare name without an ending, such as `walk`, is one that hmdwarp knows.
    """
    try:
        if isinstance(value, Path):
            return value.exists()
        named = Path(value)
        return "\0" not in value and (bool(named.suffix) or named.name != value) and named.is_file()
    except (OSError, ValueError):  # a text too long to be a name
        return False


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
