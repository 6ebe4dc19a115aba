"""The one way in for files that a user or another file names.

A file is plain (no device, pipe or socket) and within the bound of its kind. One that another file
names, or that lies in a folder which was named as a whole, lies in that folder, links followed,
unless --allow-outside. What is checked is the descriptor that is read, so that nothing can be put
in its place in between.
"""

from __future__ import annotations

import io
import os
import stat
from pathlib import Path
from typing import Any, BinaryIO, cast

import attrs

from .declared import Option
from .errors import InputError, SceneError, TraceError
from .platforms import open_checked

OUTSIDE = Option(
    "Open files outside of the folder of the file that names them, too.", bool, False, name="allow_outside"
)
_VARIABLE = "HMDWARP_ALLOW_OUTSIDE"  # in the environment, so that processes that a run starts keep to it as well
_MIB = 1 << 20
_GIB = 1 << 30
_STEP = 1 << 24
_LONGEST_NAME = 500
_OTHERS = ((stat.S_ISDIR, "a directory"), (stat.S_ISFIFO, "a pipe"), (stat.S_ISSOCK, "a socket"))
MOST_PIXELS_BYTES = 512 * _MIB  # of a picture or the arrays of an archive, unpacked


def most_unpacked(packed: int) -> int:
    """Return the most bytes that so many packed ones may become: 16 MiB, or 50 times as many."""
    return max(16 * _MIB, 50 * packed)


def unpacked(decompressor: Any, data: bytes) -> bytes:
    """Return what packed bytes hold. Errors: ValueError for too many; the decompressor's own."""
    most = most_unpacked(len(data))
    found: bytes = decompressor.decompress(data, most + 1)
    if len(found) > most or not decompressor.eof:
        raise ValueError(f"{len(data)} bytes, which end early or are more than {most} when they are unpacked")
    return found


@attrs.frozen
class FileKind:
    """A kind of file, with the most bytes that one has."""

    what: str  # in words, for messages
    most_bytes: int
    error: type[InputError] = InputError


# Whole in memory, but for the last three.
TABLE = FileKind("a text", 1_000_000)  # TOML and pages: written by hand
SECRET = FileKind("a secret or a key", 16 * 1024)
FACTS = FileKind("a JSON file", 64 * _MIB)
RESULTS = FileKind("a JSON file that hmdwarp wrote", 512 * _MIB)
LIST = FileKind("a text file", 256 * _MIB)
RATINGS = FileKind("a table of ratings (.csv, .tsv)", 200_000_000)
SCENE = FileKind("a .glb, .gltf, .obj, .ply or Mitsuba .xml file", 2 * _GIB, SceneError)
GLTF = FileKind("a .gltf file", 512 * _MIB, SceneError)  # with its pictures in it, maybe
BESIDE = FileKind("a file of a scene", 2 * _GIB)
PICTURE_FILE = FileKind("a picture or an array", 2 * _GIB)
DELAYS = FileKind("a trace with one delay in milliseconds a line", 256 * _MIB)
TRACE = FileKind("a file of head poses", 8 * _GIB, TraceError)
BAG = FileKind("a bag", 1024 * _GIB, TraceError)
VIDEO = FileKind("a video", 1024 * _GIB)


def opened(path: str | os.PathLike[str], kind: FileKind, folder: Path | None = None) -> BinaryIO:
    """Open a file for reading. Errors: those of the kind, one line; reading raises them too.

    folder: of the file that names it; None where the user does, or has named its folder (`enter`).
    """
    shown = _shown(path)
    try:
        handle = open_checked(path, lambda place: _check(place, path, kind, folder))
    except (OSError, ValueError) as error:  # a name with a zero byte, or with half a surrogate, is a ValueError
        raise kind.error(f"{shown}: {_why(error)}: expected {kind.what}") from error
    return cast("BinaryIO", io.BufferedReader(_PlainFile(handle, shown, kind), 1 << 18))


def content_of(path: str | os.PathLike[str], kind: FileKind, folder: Path | None = None) -> bytes:
    """Return the bytes of a file. Errors: as opened."""
    with opened(path, kind, folder) as file:
        return file.read()


def text_in(path: str | os.PathLike[str], kind: FileKind, folder: Path | None = None) -> str:
    """Return a text, with LF line ends and without a byte order mark. Errors: as opened."""
    data = content_of(path, kind, folder)
    try:
        return data.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise kind.error(
            f"{_shown(path)}:{line}: byte {data[error.start]:#x}: not a text file: expected {kind.what}, in UTF-8"
        ) from error


def check_inside(path: Path, folder: Path, what: str = "a file") -> Path:
    """Return the path of what a file in `folder` names. Errors: InputError for one outside."""
    try:
        path.exists()  # raises for what can be no name
        _refuse_outside(os.path.realpath(path), path, folder, what, InputError)
    except (OSError, ValueError) as error:
        raise InputError(f"{_shown(path)}: {_why(error)}: expected {what}") from error
    return path


# What a file names, to be opened later by name: the path, and the folder that it has to lie in.
_NAMED: dict[str, Path] = {}


def keep_inside(path: Path, folder: Path, what: str = "a file") -> Path:
    """Return the path as check_inside does; check again when it, or a file in it, is opened."""
    _NAMED[str(Path.cwd() / path)] = folder
    return check_inside(path, folder, what)


# Folders that were named as a whole, absolute; '..' stays in them and in what is looked up.
_ENTERED: set[str] = set()


def enter(folder: Path) -> None:
    """Keep to a folder that the user names as a whole: what lies in it may lead nowhere else."""
    _ENTERED.add(f"{Path.cwd() / folder}/")


def named_in(folder: Path, name: str) -> Path:
    """Return the path of what a file in `folder` names. Errors: as check_inside."""
    return check_inside(folder / name, folder)


def allow_outside(allowed: bool) -> None:
    """Let files name others outside of their folders, in this process and in those it starts."""
    if allowed:
        os.environ[_VARIABLE] = "1"


def _check(place: int, path: str | os.PathLike[str], kind: FileKind, folder: Path | None) -> None:
    shown, found = _shown(path), os.fstat(place)
    if not stat.S_ISREG(found.st_mode):
        what = next((name for is_one, name in _OTHERS if is_one(found.st_mode)), "a device")
        raise kind.error(f"{shown} is {what}: expected {kind.what}")
    if found.st_size > kind.most_bytes:
        raise kind.error(f"{shown}: {found.st_size} bytes: expected {kind.what}, of at most {kind.most_bytes} bytes")
    for within in _named_by(path) if folder is None else (folder,):
        _refuse_outside(str(Path(f"/proc/self/fd/{place}").readlink()), path, within, kind.what, kind.error)


def _named_by(path: str | os.PathLike[str]) -> list[Path]:
    """Return the folders that a path has to lie in: named as a whole, and of what names it."""
    absolute = Path.cwd() / path
    entered = max((name for name in _ENTERED if str(absolute).startswith(name)), key=len, default=None)
    named = [_NAMED[str(one)] for one in (absolute, *absolute.parents) if str(one) in _NAMED]
    return [*([] if entered is None else [Path(entered)]), *named]


def _refuse_outside(real: str, path: object, folder: Path, what: str, error: type[InputError]) -> None:
    if os.environ.get(_VARIABLE) or Path(real).is_relative_to(os.path.realpath(folder)):
        return
    place = "the current folder" if folder == Path() else folder
    raise error(
        f"{_shown(path)} lies outside of {place}: expected {what} in that folder: move it there, or give {OUTSIDE.flag}"
    )


def _shown(path: object) -> str:
    text = " ".join(str(path).encode("utf-8", "replace").decode().split())
    return text if len(text) <= _LONGEST_NAME else f"{text[:60]}..."


def _why(error: Exception) -> str:
    if isinstance(error, FileNotFoundError):
        return "no such file"
    return getattr(error, "strerror", None) or " ".join(str(error).split())


class _PlainFile(io.FileIO):
    """What a file held when it was opened. Errors: those of its kind, where it has grown."""

    def __init__(self, handle: int, shown: str, kind: FileKind) -> None:
        super().__init__(handle)
        self._shown, self._kind, self._size = shown, kind, os.fstat(handle).st_size

    def readinto(self, buffer: Any) -> int | None:
        count = super().readinto(buffer)
        if count:  # a reader of damaged data may have sought the end of another file
            self._refuse_growth()
        return count

    def readall(self) -> bytes:
        parts = []
        # A byte more than it has shows growth; a buffer of a whole step is 16 MiB for each file.
        while part := super().read(min(_STEP, self._size - self.tell() + 1)):
            parts.append(part)
            self._refuse_growth()
        return b"".join(parts)

    def _refuse_growth(self) -> None:
        if self.tell() > self._size:
            raise self._kind.error(
                f"{self._shown} grew while it was read: expected {self._kind.what} that is whole: wait until it is "
                "written, or read a copy"
            )
