"""Folder of a study's data, next to its file: the database, the lock and the traces."""

from __future__ import annotations

import errno
import json
import os
import socket
import sqlite3
from collections.abc import Iterable
from contextlib import suppress
from datetime import datetime
from pathlib import Path

from ...errors import HmdwarpError, InputError, MachineError
from ...platforms import NOFOLLOW, lock
from ...report import keep_private, sync
from ...scenes import inputs_beside
from ..design import Design
from .records import ORIGINS, PERSON

LOCK = "lock"
_WORDS = 1024  # bytes of the file
_HELD = frozenset({errno.EWOULDBLOCK, errno.EAGAIN, errno.EACCES})
_NOT_HERE = frozenset({errno.ENOLCK, errno.ENOSYS, errno.ENOTSUP, errno.EINVAL})


class Lock:
    """Exclusive lock of a folder. Only the kernel's flock counts; the file names the holder.

    filelock would leave the holder, full disks and the messages to its caller: most of this.
    flock and not POSIX locks: closing any handle of the file frees those, and two within one
    program do not exclude each other.
    Errors: MachineError, naming the holder, where another has it, and on a file system without
    locks; InputError where it cannot be written.
    """

    def __init__(self, folder: Path, since: datetime) -> None:
        """Take the lock. since: for the message to others."""
        self.path = folder / LOCK
        try:
            self._file = os.open(self.path, os.O_RDWR | os.O_CREAT, 0o600)
        except OSError as error:
            raise _no_place(error, folder) from error
        try:
            lock(self._file)
            self._words = {
                "pid": os.getpid(),
                "host": socket.gethostname(),
                "since": since.astimezone().isoformat(timespec="seconds"),
                "journal": noted_entries(self.path.parent),
            }
            self._write()
        except BaseException as error:
            words = self._holder()
            os.close(self._file)
            if isinstance(error, OSError):
                raise _refused(error, folder, words) from error
            raise

    def note(self, entries: int) -> None:
        """Write how many entries the journal has: a log that is lost later is missed."""
        self._words["journal"] = entries
        self._write()

    def _write(self) -> None:
        with suppress(OSError):  # a full disk: the lock is held all the same
            os.lseek(self._file, 0, os.SEEK_SET)
            os.write(self._file, json.dumps(self._words).encode().ljust(_WORDS))  # at once, over all before
            os.ftruncate(self._file, _WORDS)

    def _holder(self) -> str:
        """Return "since 14:03 on 2026-01-31, process 123 on HOST"; "" where it is not known."""
        with suppress(OSError, ValueError, KeyError, TypeError):
            os.lseek(self._file, 0, os.SEEK_SET)
            holder = json.loads(os.read(self._file, 4096))
            since = datetime.fromisoformat(holder["since"]).strftime("%H:%M on %Y-%m-%d")
            return f"since {since}, process {holder['pid']} on {holder['host']}"
        return ""

    def close(self) -> None:
        """Free the lock. The file stays: without it two could lock two files of one name."""
        if self._file >= 0:
            self._words = {"journal": self._words["journal"]}
            self._write()
            os.close(self._file)
            self._file = -1


def noted_entries(folder: Path) -> int:
    """Return how many entries the journal has at least, as Lock.note has it; 0 where unknown."""
    with suppress(OSError, ValueError, KeyError, TypeError, IndexError, RecursionError):
        if (path := folder / LOCK).is_file():
            noted = json.loads(path.read_bytes()[:_WORDS])["journal"]
            entries = int(noted[0] if isinstance(noted, list) else noted)  # a list in stores of 0.2
            return entries if 0 <= entries < 1 << 63 else 0
    return 0


def _no_place(error: OSError, folder: Path, what: str = "write") -> HmdwarpError:
    why = error.strerror or str(error)
    if error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EIO):
        return MachineError(f"{folder}: cannot write ({why}): make room, or choose another folder (--store)")
    return InputError(f"{folder}: cannot {what} ({why}): choose another folder for the study's data (--store)")


def _refused(error: OSError, folder: Path, holder: str) -> HmdwarpError:
    if error.errno in _HELD:
        who = f" ({holder})" if holder else ""
        return MachineError(f"{folder}: a session of this study is running already{who}: end it first, or wait")
    if error.errno in _NOT_HERE:
        return MachineError(
            f"{folder}: this file system cannot lock files ({error.strerror}), as some network drives; "
            "two sessions at once would not exclude each other: keep the study on a disk of this machine (--store)"
        )
    return _no_place(error, folder)


DATABASE, COPY, TRACES = "study.sqlite3", "study.copy.sqlite3", "traces"
_OURS = {DATABASE, COPY, f"{DATABASE}-wal", f"{DATABASE}-shm", f"{DATABASE}-journal", LOCK, TRACES}
_PACKAGE = Path(__file__).resolve().parents[2]


def store_folder(design: Design, folder: Path | None, origin: str = PERSON) -> Path:
    """Return `folder`; without it `<stem>-data` next to the study's file.

    Pilots lie in `<stem>-pilot-data` and simulated participants in `<stem>-simulated-data`: no
    rehearsal stands in the way of the study. The data of a shipped study lie in the current folder.
    """
    if folder is not None:
        return Path(folder)
    file = Path(design.path or f"{design.name}.toml")
    shipped = file.resolve().is_relative_to(_PACKAGE)
    whose = "" if origin == PERSON else f"-{origin}"
    return (Path() if shipped else file.parent) / f"{file.stem}{whose}-data"


def folder_to_read(design: Design, folder: Path | None, origin: str) -> Path:
    """Return as store_folder. Errors: InputError where it holds no data, naming who has some."""
    found = store_folder(design, folder, origin)
    if (found / DATABASE).exists():
        return found
    hint = ""
    for whose in ORIGINS:
        at = store_folder(design, None, whose)
        if folder is None and whose != origin and (at / DATABASE).exists():
            hint += f"; {at} is read {'without --' + origin if whose == PERSON else 'with --' + whose}"
    whose = "" if origin == PERSON else f", {origin},"
    none = f"there are no data{whose} of '{design.name}' yet"
    raise InputError(f"{found}: {none}: run sessions first, or name their folder with --store{hint}")


def make_folders(folder: Path) -> None:
    """Create the folder and that of the traces, readable by the owner only, and sync them.

    Errors: InputError for a place that cannot be written, and for a folder of something else;
    MachineError for a full disk.
    """
    try:
        if folder.is_dir():
            _check_ours(folder)
        else:
            folder.mkdir(mode=0o700, parents=True)
            sync(folder.parent)
        (folder / TRACES).mkdir(mode=0o700, exist_ok=True)
        sync(folder)
    except OSError as error:
        raise _no_place(error, folder, "be created") from error


def check_place(folder: Path) -> None:
    """Check that make_folders can succeed, without creating anything. Errors: InputError."""
    if folder.is_dir():
        _check_ours(folder)
    above = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    if not above.is_dir() or not os.access(above, os.W_OK | os.X_OK):
        why = f"{folder}: cannot be created ({above} is not writable)"
        raise InputError(f"{why}: choose another folder for the study's data (--store)")


def _check_ours(folder: Path) -> None:
    others = sorted(path.name for path in folder.iterdir() if path.name not in _OURS)
    if others and not (folder / DATABASE).exists():
        found = f"{folder}: holds something else ({others[0]})"
        raise InputError(f"{found}: a study's data need a folder of their own (--store)")


def count_of_traces(files: Iterable[Path]) -> int:
    """Count the head traces among files; inputs lie beside some."""
    paths = set(files)
    return len(paths - {inputs_beside(path) for path in paths})


def sync_trace(path: Path) -> bool:
    """Sync a trace, its inputs and their folder; False where there is no trace."""
    try:
        for each in (path, *filter(Path.is_file, [inputs_beside(path)])):
            keep_private(each)
            sync(each)
        sync(path.parent)
    except FileNotFoundError:
        return False
    except OSError as error:
        why = f"{path}: cannot be written to the disk ({error.strerror or error})"
        raise MachineError(f"{why}: resume with a copy on another disk") from error
    return True


_PART = f".{COPY}.part"
_CHUNK = 1 << 20


def write_copy(db: sqlite3.Connection, folder: Path) -> None:
    """Write the copy, whole or not at all. Errors: sqlite3.Error, OSError.

    VACUUM INTO takes one state of the database, without what was erased from it.
    """
    part = folder / _PART
    part.unlink(missing_ok=True)  # of a program that died
    try:
        os.close(os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL | NOFOLLOW, 0o600))
        db.execute("VACUUM INTO ?", (str(part),))
        sync(part)
        part.replace(folder / COPY)
        sync(folder)
    except BaseException:
        part.unlink(missing_ok=True)
        raise


def erase_copies(folder: Path) -> None:
    """Overwrite and unlink the copy, and what was left of one. Errors: OSError."""
    for path in (folder / COPY, folder / _PART):
        if path.is_file() and not path.is_symlink():
            overwrite(path)
        path.unlink(missing_ok=True)
    sync(folder)


def overwrite(path: Path) -> None:
    """Fill a file with zeros: to unlink it alone would leave its bytes on the disk."""
    handle = os.open(path, os.O_WRONLY | NOFOLLOW)
    try:
        left = os.fstat(handle).st_size
        while left > 0:
            left -= os.write(handle, bytes(min(left, _CHUNK)))
        os.fsync(handle)
    finally:
        os.close(handle)
