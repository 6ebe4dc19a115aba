"""The tables, and how the file is opened."""

from __future__ import annotations

import os
import sqlite3
from pathlib import Path
from urllib.parse import quote

from ...errors import InputError, MachineError
from .faults import RECOVER, told, transaction

FILE = "study.sqlite3"
SCHEMA = 1
APPLICATION_ID = 0x686D6477  # "hmdw": so that a database of something else is known
BUSY_MS = 5000  # somebody's reader may hold it for a moment, at a checkpoint

# No row keeps a date, a sub or a name of somebody who withdrew: `withdrawn` has the code alone. cleaned: whether the bytes are gone too.
# AUTOINCREMENT: a number that was used never comes back, so that an id in an old export can never mean somebody else's row.
TABLES = """
CREATE TABLE study (name TEXT NOT NULL, made_by TEXT NOT NULL) STRICT;
CREATE TABLE plan (id INTEGER PRIMARY KEY, text TEXT NOT NULL, meaning TEXT NOT NULL, UNIQUE (text, meaning)) STRICT;
CREATE TABLE participant (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  code TEXT NOT NULL UNIQUE COLLATE NOCASE,
  sub TEXT NOT NULL UNIQUE,
  origin TEXT NOT NULL CHECK (origin IN ('person', 'pilot', 'simulated')),
  withdrawing INTEGER NOT NULL DEFAULT 0
) STRICT;
CREATE TABLE session (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  participant INTEGER NOT NULL REFERENCES participant (id),
  number INTEGER NOT NULL CHECK (number >= 1),
  part TEXT NOT NULL,
  order_row INTEGER NOT NULL,
  order_names TEXT NOT NULL,
  plan INTEGER NOT NULL REFERENCES plan (id),
  status TEXT NOT NULL CHECK (status IN ('running', 'interrupted', 'complete', 'stopped', 'sick')),
  why TEXT NOT NULL DEFAULT '',
  started_utc TEXT NOT NULL,
  ended_utc TEXT NOT NULL DEFAULT '',
  facts TEXT NOT NULL,
  UNIQUE (participant, number)
) STRICT;
CREATE TABLE showing (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  session INTEGER NOT NULL REFERENCES session (id),
  key TEXT NOT NULL,
  trial INTEGER NOT NULL,
  repeat INTEGER NOT NULL,
  condition TEXT NOT NULL,
  presentation INTEGER NOT NULL CHECK (presentation >= 1),
  complete INTEGER NOT NULL DEFAULT 0 CHECK (complete IN (0, 1)),
  settings TEXT NOT NULL,
  trace TEXT NOT NULL,
  actual TEXT NOT NULL DEFAULT '{}',
  measured TEXT NOT NULL DEFAULT '{}',
  started_utc TEXT NOT NULL,
  UNIQUE (session, key, presentation)
) STRICT;
CREATE TABLE answer (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  session INTEGER NOT NULL REFERENCES session (id),
  key TEXT NOT NULL,
  revision INTEGER NOT NULL CHECK (revision >= 1),
  phase TEXT NOT NULL,
  trial INTEGER NOT NULL,
  scale TEXT NOT NULL,
  item TEXT NOT NULL,
  value REAL,
  seconds REAL NOT NULL,
  answered_by TEXT NOT NULL,
  at_utc TEXT NOT NULL,
  showing INTEGER REFERENCES showing (id),
  UNIQUE (session, key, revision)
) STRICT;
CREATE TABLE event (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  session INTEGER NOT NULL REFERENCES session (id),
  kind TEXT NOT NULL,
  key TEXT NOT NULL,
  at_utc TEXT NOT NULL,
  mono_ns INTEGER NOT NULL,
  data TEXT NOT NULL
) STRICT;
CREATE INDEX event_of_session ON event (session, kind);
CREATE TABLE withdrawn (code TEXT NOT NULL PRIMARY KEY COLLATE NOCASE, cleaned INTEGER NOT NULL) STRICT;
"""


def open_to_write(folder: Path) -> sqlite3.Connection:
    """The store of a folder, for the one who has its lock; checked from end to end first.

    WAL and synchronous=FULL: a commit is one append and one fsync, and readers see the state before it meanwhile.
    Errors: as faults.store_error; InputError for a file that is damaged, of a newer program, or something else.
    """
    path = folder / FILE
    with told(path):
        db = _connect(path, "rw")
        try:
            db.execute("PRAGMA journal_mode = WAL")
            for setting in ("synchronous = FULL", "foreign_keys = ON", "secure_delete = ON", "temp_store = MEMORY"):
                db.execute(f"PRAGMA {setting}")
            _check_schema(db, path)
            found = db.execute("PRAGMA integrity_check(1)").fetchone()[0]
            if found != "ok":
                raise _damaged(path, found)
            return db
        except BaseException:
            db.close()
            raise


def open_to_read(folder: Path) -> sqlite3.Connection:
    """The store of a folder as it is now, a writer beside it or not. Errors: as open_to_write."""
    path = folder / FILE
    with told(path):
        try:
            return _reader(path, "mode=ro")
        except sqlite3.OperationalError:
            if not path.is_file() or os.access(folder, os.W_OK):
                raise
        return _reader(path, _frozen(path))


def make(folder: Path, study: str, made_by: str) -> None:
    """A new, empty store; all of it or nothing. With the lock."""
    path = folder / FILE
    with told(path):
        db = _connect(path, "rwc")
        try:
            db.execute("PRAGMA journal_mode = WAL")
            db.execute("PRAGMA synchronous = FULL")
            with transaction(db, path):
                for statement in TABLES.split(";\n"):
                    db.execute(statement)
                db.execute("INSERT INTO study VALUES (?, ?)", (study, made_by))
                db.execute(f"PRAGMA application_id = {APPLICATION_ID}")
                db.execute(f"PRAGMA user_version = {SCHEMA}")
        finally:
            db.close()


def is_made(folder: Path) -> bool:
    """Whether there is more than the beginnings of a file: a program that died while it made one leaves an empty database."""
    path = folder / FILE
    if not path.is_file() or not path.stat().st_size:
        return False
    with told(path):
        db = _connect(path, "ro")
        try:
            return db.execute("SELECT count(*) FROM sqlite_master").fetchone()[0] > 0
        finally:
            db.close()


def _connect(path: Path, mode: str) -> sqlite3.Connection:
    return sqlite3.connect(f"file:{quote(str(path.absolute()))}?mode={mode}", uri=True, isolation_level=None, timeout=BUSY_MS / 1000)


def _reader(path: Path, how: str) -> sqlite3.Connection:
    db = sqlite3.connect(f"file:{quote(str(path.absolute()))}?{how}", uri=True, isolation_level=None, timeout=BUSY_MS / 1000)
    try:
        _check_schema(db, path)
        return db
    except BaseException:
        db.close()
        raise


def _frozen(path: Path) -> str:
    """How to read where nothing may be written: without the files that readers share. What is still in the WAL would be missed."""
    wal = path.with_name(path.name + "-wal")
    if wal.is_file() and wal.stat().st_size:
        raise MachineError(f"{path.parent}: its last session was cut off, and nothing may be written there: copy the folder, read the copy")
    return "immutable=1"


def _check_schema(db: sqlite3.Connection, path: Path) -> None:
    application, version = (db.execute(f"PRAGMA {name}").fetchone()[0] for name in ("application_id", "user_version"))
    if application != APPLICATION_ID:
        raise InputError(f"{path}: a database, but not of a study of hmdwarp: choose another folder (--store)")
    if version > SCHEMA:
        raise InputError(f"{path}: written by a newer hmdwarp (schema {version}; this one knows {SCHEMA}): bring hmdwarp up to date")


def _damaged(path: Path, found: str) -> InputError:
    return InputError(f"{path}: damaged ({found}): {RECOVER}")
