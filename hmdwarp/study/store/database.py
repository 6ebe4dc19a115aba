"""Tables of the database, how its file is opened, and its errors translated for users."""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from urllib.parse import quote

from ...errors import HmdwarpError, InputError, MachineError
from ...report import sync
from .folders import DATABASE

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
        f"the disk fails or a quota is used up ({{error}}); {KEPT}: resume with a copy on another disk (--store)",
    ),
    (
        "SQLITE_CANTOPEN",
        MachineError,
        "it cannot be opened ({error}): check that the folder exists and is writable",
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
    ("SQLITE_CORRUPT", InputError, f"it is damaged ({{error}}): {RECOVER}"),
)


def store_error(error: sqlite3.Error, path: Path) -> HmdwarpError:
    """Translate an error; a violated constraint and unknown errors are internal errors."""
    name = getattr(error, "sqlite_errorname", None) or ""
    if name.startswith("SQLITE_IOERR") and _is_full(path.parent):
        name = "SQLITE_FULL"  # the shared memory of the log reports it so
    for begins, kind, words in _TEXTS:
        if name.startswith(begins):
            return kind(f"{path}: {words.format(error=error)}")
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


SCHEMA = 1
APPLICATION_ID = 0x686D6477  # "hmdw": recognises databases of other programs
BUSY_S = 5.0  # a reader may hold it for a moment, at a checkpoint

# No row keeps a date, a random word or a name of a participant who withdrew: `withdrawn` has only
# the code. cleaned: whether the bytes are gone too. AUTOINCREMENT: ids are never reused, so that an
# id in an old export cannot mean another participant's row. A declined or unconsented session is
# 'stopped' in session.status; its journal tells (queries.py), as in the stores of older versions.
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


def open_to_write(folder: Path, study: str, made_by: str) -> sqlite3.Connection:
    """Open the database of a folder whose lock is held; create it, or check it from end to end.

    WAL and synchronous=FULL: a commit is one append and one fsync, while readers see the state
    before it. study, made_by: of a new database.
    Errors: as faults.store_error; InputError for a file that is damaged, of a newer program, or of
    another kind; MachineError for a disk that cannot hold one.
    """
    path = folder / DATABASE
    with translated(path):
        with suppress(OSError):  # SQLite says why; its log gets the same mode
            os.close(os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o600))
        db = _connect(path, "mode=rwc")
        try:
            new = _is_empty(db)
            if not new:
                _check_schema(db, path)
            _set_up(db, path)
            if new:
                _make(db, path, study, made_by)
            found = db.execute("PRAGMA integrity_check(1)").fetchone()[0]
            if found != "ok":
                raise InputError(f"{path}: damaged ({found.splitlines()[-1]}): {RECOVER}")
            return db
        except BaseException:
            db.close()
            raise


def _set_up(db: sqlite3.Connection, path: Path) -> None:
    mode = db.execute("PRAGMA journal_mode = WAL").fetchone()[0]
    if mode != "wal":
        raise MachineError(
            f"{path}: the disk cannot hold a write-ahead log ({mode}): keep the study on a disk of this machine "
            "(--store)"
        )
    for setting in ("synchronous = FULL", "foreign_keys = ON", "secure_delete = ON", "temp_store = MEMORY"):
        db.execute(f"PRAGMA {setting}")


def _make(db: sqlite3.Connection, path: Path, study: str, made_by: str) -> None:
    """Create all tables or none."""
    with transaction(db, path):
        for statement in TABLES.split(";\n"):
            db.execute(statement)
        db.execute("INSERT INTO study VALUES (?, ?)", (study, made_by))
        db.execute(f"PRAGMA application_id = {APPLICATION_ID}")
        db.execute(f"PRAGMA user_version = {SCHEMA}")
    sync(path.parent)


def open_to_read(folder: Path) -> sqlite3.Connection | None:
    """Open the database for reading, even while it is written; None where there is none yet.

    Errors: as open_to_write.
    """
    path = folder / DATABASE
    if not path.is_file():
        return None
    with translated(path):
        try:
            return _reader(path, "mode=ro")
        except sqlite3.OperationalError as error:
            if not os.access(folder, os.W_OK):
                return _reader(path, _frozen(path))
            if not error.sqlite_errorname.startswith("SQLITE_READONLY"):
                raise
        # A program that died while it created the file left a journal: the reader must roll it
        # back.
        return _reader(path, "mode=rw")


def _reader(path: Path, how: str) -> sqlite3.Connection | None:
    db = _connect(path, how)
    try:
        db.execute("PRAGMA query_only = ON")
        if _is_empty(db):
            db.close()
            return None
        _check_schema(db, path)
        return db
    except BaseException:
        db.close()
        raise


def _is_empty(db: sqlite3.Connection) -> bool:
    """Return whether a program died while it created the database."""
    return bool(db.execute("SELECT count(*) FROM sqlite_master").fetchone()[0] == 0)


def _connect(path: Path, how: str) -> sqlite3.Connection:
    return sqlite3.connect(f"file:{quote(str(path.absolute()))}?{how}", uri=True, isolation_level=None, timeout=BUSY_S)


def _frozen(path: Path) -> str:
    """Return how to read where nothing may be written: without the files that readers share.

    Data that are still in the WAL would be missed.
    """
    beside = [path.with_name(path.name + end) for end in ("-wal", "-journal")]
    if any(path.is_file() and path.stat().st_size for path in beside):
        raise MachineError(
            f"{path.parent}: its last session was cut off, and the folder is not writable: copy the folder and "
            "read the copy"
        )
    return "immutable=1"


def _check_schema(db: sqlite3.Connection, path: Path) -> None:
    application, version = (db.execute(f"PRAGMA {name}").fetchone()[0] for name in ("application_id", "user_version"))
    if application != APPLICATION_ID:
        raise InputError(f"{path}: a database, but not of an hmdwarp study: choose another folder (--store)")
    if version > SCHEMA:
        raise InputError(
            f"{path}: written by a newer hmdwarp (schema {version}; this one knows {SCHEMA}): update hmdwarp"
        )
