"""Newest copy of a store's database: written at the end of each session, beside the database."""

from __future__ import annotations

import os
import sqlite3
from pathlib import Path

from ...platforms import NOFOLLOW
from ...report import sync
from .folders import COPY

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
