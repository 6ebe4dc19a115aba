"""A study's files: folder, lock, traces, the database and its copy, and errors in words."""

from __future__ import annotations

import errno
import functools
import json
import os
import shutil
import socket
import sqlite3
from collections.abc import Iterable, Iterator
from contextlib import closing, contextmanager, suppress
from datetime import datetime
from pathlib import Path
from urllib.parse import quote

from ...base import NOFOLLOW, HmdwarpError, InputError, MachineError, lock
from ...report import keep_private, sync
from ...scenes import inputs_beside
from ..design import Design
from .records import ORIGINS, PERSON, DamagedRow, dict_in, from_json

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
                "journal": _noted_entries(self.path.parent),
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


def _noted_entries(folder: Path) -> int:
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


# --- the database

_LEAST_BYTES = 65536  # the shared memory of a log grows by half of that
KEPT = "everything that was confirmed is kept"
_NOT_A_DATABASE = "it is no database, or another file"
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
        return damaged(path, _NOT_A_DATABASE if name == "SQLITE_NOTADB" else str(error))
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
    if _noted_entries(path.parent) or path.with_name(COPY).exists() or any((path.parent / TRACES).glob("*.csv")):
        raise damaged(path, "there is no data in it, and there were sessions")


def check(db: sqlite3.Connection, path: Path) -> None:
    """Check a database from end to end. Errors: InputError as `damaged`.

    SQLite finds damage of its own structures, the count beside it that a log or a newer file is
    gone.
    """
    noted = _noted_entries(path.parent)  # first: another program may be writing
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
