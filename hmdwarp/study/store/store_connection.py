"""Connection to a store, for reading or for writing under the lock; transactions and journal."""

from __future__ import annotations

import sqlite3
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Protocol, Self

from ...errors import HmdwarpError, InputError
from ...report import keep_private
from ...resources import __version__
from . import database, queries
from .copies import write_copy
from .database import transaction
from .erasing import finish_erasing
from .folders import DATABASE, TRACES, Lock, make_folders
from .records import INTERRUPTED, RUNNING, Session, to_json


class Clock(Protocol):
    """Time of day, which may be set back, and time since boot, which never is."""

    def utc(self) -> datetime:
        """Return the time of day, with a time zone."""

    def mono_ns(self) -> int:
        """Return nanoseconds since some instant."""


class MachineClock:
    """The machine's own clock."""

    def utc(self) -> datetime:
        """Return the time of day, in UTC."""
        return datetime.now(UTC)

    def mono_ns(self) -> int:
        """Return nanoseconds of the monotonic clock."""
        return time.monotonic_ns()


def text_of(instant: datetime) -> str:
    """Format as ISO 8601 to the millisecond, of fixed length: texts sort as instants do."""
    return instant.astimezone(UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")


def seconds_back(before: str, now: str) -> float:
    """Return by how much `now` lies before `before`; negative where it does not."""
    return (datetime.fromisoformat(before) - datetime.fromisoformat(now)).total_seconds()


BACK_S = 1.0  # less is the network correcting the clock, and no order depends on it
NOTHING = "holds no data of a study"


class StoreConnection:
    """Connection of a Store: it opens for reading, and writes under the lock; a context manager."""

    def __init__(self, folder: Path, create: bool, study: str | None, say: Callable[[str], None], clock: Clock) -> None:
        """Open for reading. study: name that the store must have; None for any."""
        self.folder, self.traces = folder, folder / TRACES
        self._path, self._say, self._clock = folder / DATABASE, say, clock
        self._create, self._study = create, study
        self._lock: Lock | None = None
        self._finished: list[str] = []  # codes whose interrupted withdrawal ended when the lock was taken
        self._open = database.open_to_read(folder)
        if self._open is None and not create:
            raise InputError(
                f"{folder}: {NOTHING} (no {DATABASE}): run a session first, or name the folder with --store"
            )
        try:
            self._check_name(study)
        except InputError:
            self.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Free lock and database. May be called twice. A session without an end may be resumed."""
        if self._open is not None:
            self._open.close()
            self._open = None
        if self._lock is not None:
            self._lock.close()
            self._lock = None

    @property
    def name(self) -> str:
        """Name of the study; "" for an empty store."""
        return "" if self._open is None else queries.study_name(self._open)

    @property
    def _db(self) -> sqlite3.Connection:
        """The database, to read from."""
        if self._open is None:
            raise InputError(f"{self.folder}: {NOTHING} yet: run a session first")
        return self._open

    def _take_lock(self, study: str | None = None) -> bool:
        """Take the lock for writing; False where it is held already.

        study: name of the study, without which no store is created.
        """
        self._check_name(study)
        if self._lock is not None:
            return False
        if self._create and study:
            make_folders(self.folder)
        else:
            _ = self._db  # there must be one
        keep_private(self.folder, *self.folder.rglob("*"))
        lock = Lock(self.folder, self._clock.utc())
        try:
            db = database.open_to_write(self.folder, study or "", __version__)
        except BaseException:
            lock.close()
            raise
        self.close()
        self._open, self._lock = db, lock
        self._check_name(study)
        self._tidy()
        return True

    def _free_lock(self) -> None:
        """Free the lock and go on reading."""
        self.close()
        self._open = database.open_to_read(self.folder)

    def _tidy(self) -> None:
        """Mark sessions of dead programs as interrupted, and finish interrupted withdrawals.

        The lock excludes other programs: a session that still runs belongs to one that died.
        """
        self._finished = finish_erasing(self._db, self.folder)
        for code in self._finished:
            self._say(f"the withdrawal of participant {code} was interrupted; it is finished now")
            self._copy()
        died = [id_ for (id_,) in self._db.execute("SELECT id FROM session WHERE status = ?", (RUNNING,))]
        with self._write() as db:
            for id_ in died:
                self._event(queries.session(db, id_), "interrupted", data={"why": "the program died"})
                db.execute("UPDATE session SET status = ? WHERE id = ?", (INTERRUPTED, id_))

    def _copy(self, *, told: bool = True) -> None:
        """Renew the copy; that it fails, as on a full disk, costs no session.

        told: whether it says so.
        """
        try:
            write_copy(self._db, self.folder)
        except (sqlite3.Error, OSError) as error:
            if told:
                self._say(f"the store's copy could not be renewed ({error}); everything is in the store itself")

    def _check_name(self, study: str | None) -> None:
        wanted = study or self._study
        if wanted and self.name and self.name != wanted:
            raise InputError(
                f"{self.folder}: holds the study '{self.name}', not '{wanted}': choose another folder (--store)"
            )

    @contextmanager
    def _write(self) -> Iterator[sqlite3.Connection]:
        """Open a transaction; it is on the disk when the block ends."""
        assert self._lock is not None, "writing needs the lock"
        with transaction(self._db, self._path) as db:
            yield db
        self._lock.note(database.entries_of(self._db))

    @contextmanager
    def _running(self, session: Session) -> Iterator[sqlite3.Connection]:
        """Open a transaction of a running session.

        Errors: HmdwarpError, an internal error, where it is over.
        """
        with self._write() as db:
            now = queries.session(db, session.id)
            if now.status != RUNNING:
                raise HmdwarpError(
                    f"session {now.number} of participant {now.code} is {now.status}: nothing more can be stored in it"
                )
            yield db

    def _now(self) -> str:
        """Return the time of day as rows hold it."""
        return text_of(self._clock.utc())

    def _event(
        self,
        session: Session,
        kind: str,
        key: str = "",
        data: Mapping[str, Any] | None = None,
    ) -> None:
        """Append to the journal; an event before it notes a clock that was set back."""
        now, mono_ns = self._now(), self._clock.mono_ns()
        latest = self._db.execute("SELECT at_utc, session FROM event ORDER BY id DESC LIMIT 1").fetchone()
        insert = "INSERT INTO event (session, kind, key, at_utc, mono_ns, data) VALUES (?, ?, ?, ?, ?, ?)"
        if latest is not None and (back_s := seconds_back(latest[0], now)) >= BACK_S:
            # No time of another session: this entry stays when that session's participant
            # withdraws.
            noted = {"before": latest[0], "back_s": back_s} if latest[1] == session.id else {}
            self._db.execute(insert, (session.id, "clock", "", now, mono_ns, to_json(noted)))
            self._say(
                f"the machine's clock was set back by {back_s:.0f} s: nothing is lost; the order of the data does "
                "not depend on it"
            )
        self._db.execute(insert, (session.id, kind, key, now, mono_ns, to_json(data or {})))
