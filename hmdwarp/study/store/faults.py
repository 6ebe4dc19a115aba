"""Errors of SQLite and the system, translated for users."""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from ...errors import HmdwarpError, InputError, MachineError

_LEAST_BYTES = 65536  # the shared memory of a log grows by half of that
KEPT = "everything that was confirmed is kept"
RECOVER = "keep the folder as it is and work on a copy; `sqlite3 FILE .recover` saves what can be"
_TEXTS: tuple[tuple[str, type[HmdwarpError], str], ...] = (
    ("SQLITE_FULL", MachineError, f"no room is left on the disk; {KEPT}: make room and resume (study run --resume)"),
    ("SQLITE_READONLY", InputError, f"it may not be written to; {KEPT}: make it writable, or use a copy (--store)"),
    ("SQLITE_PERM", InputError, "it may not be opened: check who owns it"),
    ("SQLITE_AUTH", InputError, "it may not be opened: check who owns it"),
    (
        "SQLITE_IOERR",
        MachineError,
        f"the disk fails or a quota is used up ({{said}}); {KEPT}: resume with a copy on another disk (--store)",
    ),
    (
        "SQLITE_CANTOPEN",
        MachineError,
        "it cannot be opened ({said}): check that the folder exists and is writable",
    ),
    ("SQLITE_BUSY", MachineError, "another program holds it: close programs that read the study's data, and try again"),
    (
        "SQLITE_LOCKED",
        MachineError,
        "another program holds it: close programs that read the study's data, and try again",
    ),
    (
        "SQLITE_NOTADB",
        InputError,
        "it is no database: it is damaged, or another file; keep it as it is and use an earlier copy",
    ),
    ("SQLITE_CORRUPT", InputError, f"it is damaged ({{said}}): {RECOVER}"),
)


def store_error(error: sqlite3.Error, path: Path) -> HmdwarpError:
    """Translate an error; a violated constraint and unknown errors are internal errors."""
    name = getattr(error, "sqlite_errorname", None) or ""
    if name.startswith("SQLITE_IOERR") and _is_full(path.parent):
        name = "SQLITE_FULL"  # the shared memory beside the log reports it so
    for begins, kind, words in _TEXTS:
        if name.startswith(begins):
            return kind(f"{path}: {words.format(said=error)}")
    return HmdwarpError(f"{path}: {error} ({name or type(error).__name__})")


def _is_full(folder: Path) -> bool:
    try:
        found = os.statvfs(folder)
    except OSError:
        return False
    return found.f_bavail * found.f_frsize < _LEAST_BYTES


@contextmanager
def translated(path: Path) -> Iterator[None]:
    """Raise SQLite's errors in this block as store_error translates them."""
    try:
        yield
    except sqlite3.Error as error:
        raise store_error(error, path) from error


@contextmanager
def transaction(db: sqlite3.Connection, path: Path) -> Iterator[sqlite3.Connection]:
    """Put all of the block on the disk, synced, or nothing of it. Errors: as store_error."""
    with translated(path):
        db.execute("BEGIN IMMEDIATE")
        try:
            yield db
            db.execute("COMMIT")
        except BaseException:  # a signal's too: the next transaction must be able to begin
            if db.in_transaction:  # a full disk may have rolled it back already
                with suppress(sqlite3.Error):
                    db.execute("ROLLBACK")
            raise
