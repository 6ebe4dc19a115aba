"""Tables of the database, how its file is opened, and its errors translated for users."""

from __future__ import annotations

import functools
import os
import shutil
import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from datetime import datetime
from pathlib import Path
from urllib.parse import quote

from ...errors import HmdwarpError, InputError, MachineError
from ...platforms import NOFOLLOW
from ...report import sync
from .folders import COPY, DATABASE, LOCK, TRACES, noted_entries
from .records import DamagedRow, dict_in, from_json

_LEAST_BYTES = 65536  # the shared memory of a log grows by half of that
KEPT = "everything that was confirmed is kept"
NOT_A_DATABASE = "it is no database, or another file"
_TEXTS: tuple[tuple[tuple[str, ...], type[HmdwarpError], str], ...] = (
    (("SQLITE_FULL",), MachineError, f"no room is left on the disk; {KEPT}: make room and resume (study run --resume)"),
    (("SQLITE_READONLY",), InputError, f"it may not be written to; {KEPT}: make it writable, or use a copy (--store)"),
    (("SQLITE_PERM", "SQLITE_AUTH"), InputError, "it may not be opened: check who owns it"),
    (
        ("SQLITE_IOERR",),
        MachineError,
        f"the disk fails or a quota is used up ({{error}}); {KEPT}: resume with a copy on another disk (--store)",
    ),
    (
        ("SQLITE_CANTOPEN",),
        MachineError,
        "it cannot be opened ({error}): check that the folder exists and is writable",
    ),
    (
        ("SQLITE_BUSY", "SQLITE_LOCKED"),
        MachineError,
        "another program holds it: close programs that read the study's data, and try again",
    ),
)


def store_error(error: sqlite3.Error | UnicodeDecodeError, path: Path) -> HmdwarpError:
    """Translate an error; a violated constraint and unknown errors are internal errors."""
    if isinstance(error, UnicodeDecodeError):  # SQLite's own message holds bytes of a broken schema
        return damaged(path, "its schema holds bytes that are no text")
    name = getattr(error, "sqlite_errorname", None) or ""
    # SQLITE_ERROR: the schema is not what the file says it is.
    if name in ("SQLITE_ERROR", "SQLITE_NOTADB") or name.startswith("SQLITE_CORRUPT") or "UTF-8" in str(error):
        return damaged(path, NOT_A_DATABASE if name == "SQLITE_NOTADB" else str(error))
    if name.startswith("SQLITE_IOERR"):
        with suppress(OSError):
            if shutil.disk_usage(path.parent).free < _LEAST_BYTES:
                name = "SQLITE_FULL"  # the shared memory of the log reports it so
    for begins, kind, words in _TEXTS:
        if name.startswith(begins):
            return kind(f"{path}: {words.format(error=error)}")
    return HmdwarpError(f"{path}: {error} ({name or type(error).__name__})")


def damaged(path: Path, why: str) -> InputError:
    """Return the error of a damaged database, with its newest copy and how to use that."""
    copy = path.with_name(COPY)
    try:
        of = datetime.fromtimestamp(copy.stat().st_mtime).astimezone().isoformat(" ", "minutes")
        how = (
            f"the newest copy, {copy}, is of {of}: in a copy of the folder delete {DATABASE}, {DATABASE}-wal, "
            f"{DATABASE}-shm and {LOCK}, rename {COPY} to {DATABASE}, and name that folder with --store"
        )
    except OSError:
        how = "there is no copy, as no session has ended: use a backup of the folder"
    return InputError(f"{path}: damaged ({' '.join(why.split())}): leave it as it is; {how}")


@contextmanager
def translated(path: Path) -> Iterator[None]:
    """Raise SQLite's errors in this block as store_error translates them."""
    try:
        yield
    except (sqlite3.Error, UnicodeDecodeError) as error:
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
SYNCHRONOUS = "FULL"  # a commit returns after an fsync
_SETTINGS = (f"synchronous = {SYNCHRONOUS}", "foreign_keys = ON", "secure_delete = ON", "temp_store = MEMORY")
BUSY_S = 5.0  # a reader may hold it for a moment, at a checkpoint

# The statements alone: SQLite keeps their text in each store.
TABLES = "".join(Path(__file__).with_name("tables.sql").read_text(encoding="utf-8").partition("CREATE")[1:])


def open_to_write(folder: Path, study: str, made_by: str) -> sqlite3.Connection:
    """Open the database of a folder whose lock is held; create it, or check it from end to end.

    WAL and SYNCHRONOUS: a commit is one append and one fsync, while readers see the state
    before it. study, made_by: of a new database.
    Errors: as store_error; InputError for a file that is damaged, of a newer program, or of
    another kind; MachineError for a disk that cannot hold one.
    """
    path = folder / DATABASE
    with translated(path):
        with suppress(OSError):  # SQLite says why; its log gets the same mode
            os.close(os.open(path, os.O_RDWR | os.O_CREAT | NOFOLLOW, 0o600))
        db = _connect(path, "mode=rwc")
        try:
            new = _is_empty(db)
            if new:
                _refuse_lost(path)
            else:
                _check_schema(db, path)
            mode = db.execute("PRAGMA journal_mode = WAL").fetchone()[0]
            if mode != "wal":
                cannot = f"the disk cannot hold a write-ahead log ({mode})"
                raise MachineError(f"{path}: {cannot}: keep the study on a disk of this machine (--store)")
            for setting in _SETTINGS:
                db.execute(f"PRAGMA {setting}")
            if new:
                with transaction(db, path):
                    for statement in TABLES.split(";\n"):
                        db.execute(statement)
                    db.execute("INSERT INTO study VALUES (?, ?)", (study, made_by))
                    db.execute(f"PRAGMA application_id = {APPLICATION_ID}")
                    db.execute(f"PRAGMA user_version = {SCHEMA}")
                sync(path.parent)
            check(db, path)
            return db
        except BaseException:
            db.close()
            raise


def open_to_read(folder: Path) -> sqlite3.Connection | None:
    """Open the database for reading, even while it is written; None where there is none yet."""
    path = folder / DATABASE
    if not path.is_file():
        _refuse_lost(path)
        return None
    with translated(path):
        try:
            return _reader(path, "mode=ro")
        except sqlite3.OperationalError as error:
            if not os.access(folder, os.W_OK):
                return _reader(path, _frozen(path))
            if not getattr(error, "sqlite_errorname", "").startswith("SQLITE_READONLY"):
                raise
        # A program that died while it created the file left a journal: the reader must roll it
        # back.
        return _reader(path, "mode=rw")


def _reader(path: Path, how: str) -> sqlite3.Connection | None:
    db = _connect(path, how)
    try:
        db.execute("PRAGMA query_only = ON")
        if _is_empty(db):
            _refuse_lost(path)
            db.close()
            return None
        _check_schema(db, path)
        check(db, path)
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
    """Return how to read, without files that readers share, where nothing is left in a log."""
    beside = [path.with_name(path.name + end) for end in ("-wal", "-journal")]
    if any(path.is_file() and path.stat().st_size for path in beside):
        cut_off = "its last session was cut off, and the folder is not writable"
        raise MachineError(f"{path.parent}: {cut_off}: copy the folder and read the copy")
    return "immutable=1"


def _refuse_lost(path: Path) -> None:
    """Refuse to take a study for a new one whose database is gone."""
    if os.path.lexists(path) and not path.is_file():
        raise damaged(path, "it is no regular file")
    if noted_entries(path.parent) or path.with_name(COPY).exists() or any((path.parent / TRACES).glob("*.csv")):
        raise damaged(path, "there is no data in it, and there were sessions")


def check(db: sqlite3.Connection, path: Path) -> None:
    """Check a database from end to end. Errors: InputError as `damaged`.

    SQLite finds damage of its own structures, the count beside it that a log or a newer file is
    gone.
    """
    noted = noted_entries(path.parent)  # first: another program may be writing
    db.execute("BEGIN")
    try:
        wrong = [text for (text,) in db.execute("PRAGMA integrity_check(1)") if text != "ok"]
        wrong = wrong or [
            f"a {table} without its {parent}" for table, _, parent, _ in db.execute("PRAGMA foreign_key_check")
        ]
        if wrong:
            raise damaged(path, wrong[0].splitlines()[-1])
        for table, own in columns().items():
            for row in db.execute(f"SELECT * FROM {table}"):  # SQLite itself checks no text
                for name, value in zip(own, row, strict=True):
                    if name in _JSON:
                        dict_in(value)
                    elif name == "order_names":
                        from_json(value)
        if (missing := noted - entries_of(db)) > 0:
            raise damaged(
                path, f"the last {missing} of {noted} entries of its journal are not there: was its log lost?"
            )
    finally:
        if db.in_transaction:
            db.execute("ROLLBACK")


_JSON = ("facts", "settings", "actual", "measured", "data", "meaning")


def entries_of(db: sqlite3.Connection) -> int:
    """Return how many entries the journal has had, with erased ones."""
    (entries,) = db.execute("SELECT seq FROM sqlite_sequence WHERE name = 'event'").fetchone() or (0,)
    if not isinstance(entries, int):
        raise DamagedRow(f"no count of its journal in {entries!r}")
    return entries


@functools.cache
def columns() -> dict[str, dict[str, str]]:
    """Return the columns of each table, and the type of each."""
    with closing(sqlite3.connect(":memory:")) as db:
        db.executescript(TABLES)
        tables = db.execute("SELECT name FROM sqlite_master WHERE sql LIKE '%STRICT'").fetchall()
        return {table: columns_of(db, table) for (table,) in tables}


def columns_of(db: sqlite3.Connection, table: str) -> dict[str, str]:
    """Return the columns that a table has in a database, and the type of each."""
    return dict(db.execute("SELECT name, type FROM pragma_table_info(?)", (table,)).fetchall())


def _check_schema(db: sqlite3.Connection, path: Path) -> None:
    application, version = (db.execute(f"PRAGMA {name}").fetchone()[0] for name in ("application_id", "user_version"))
    fits = all(columns_of(db, table) == own for table, own in columns().items())
    if application != APPLICATION_ID and not fits:
        raise InputError(f"{path}: a database, but not of an hmdwarp study: choose another folder (--store)")
    if version > SCHEMA and application == APPLICATION_ID:
        newer = f"written by a newer hmdwarp (schema {version}; this one knows {SCHEMA})"
        raise InputError(f"{path}: {newer}: update hmdwarp")
    if not fits or (application, version) != (APPLICATION_ID, SCHEMA):
        raise damaged(path, f"its tables are not those of schema {SCHEMA}, it says schema {version}")
