"""Store of a study: every event is on the disk when the call that records it returns.

SQLite rather than an append-only log, because
* withdrawal must erase in the middle: a log would be rewritten, valid at every instant;
* constraints against a doubled rating are part of the file (UNIQUE over session, question and
  revision), not of the program that writes it;
* an event, its row and the order that it takes are one transaction: a crash leaves nothing between;
* an export may read while a session writes.
WAL with synchronous=FULL: a commit returns after an fsync. A lock of the kernel, which ends with
the program, allows one writer at a time.
"""

from __future__ import annotations

import hashlib
import math
import sqlite3
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Self

from ...base import HmdwarpError, InputError, __version__
from ...report import keep_private
from ..design import Ask, Design, Show
from . import admission, database, records
from .database import DATABASE, TRACES, Lock, transaction, translated
from .erasing import Holdings, erase, finish_erasing, known
from .records import Answer, Contents, Session, Showing, clean, to_json


class _MachineClock:
    """Time of day, which may be set back, and nanoseconds since boot, which never are."""

    def utc(self) -> datetime:
        return datetime.now(UTC)

    def mono_ns(self) -> int:
        return time.monotonic_ns()


def text_of(instant: datetime) -> str:
    """Format as ISO 8601 to the millisecond, of fixed length: texts sort as instants do."""
    return instant.astimezone(UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")


BACK_S = 1.0  # less is the network correcting the clock, and no order depends on it
NOTHING = "holds no data of a study"


class _Undone(Exception):  # noqa: N818 (no error: rolls a transaction back)
    """Rolls back a transaction that was only a trial."""


class Store:
    """Data of one study in a folder; a context manager.

    It opens for reading, which needs no lock; the first call that writes takes the lock until the
    store is closed.
    Errors, of every method too: InputError and MachineError, as store_error and Lock.
    """

    def __init__(
        self,
        folder: Path,
        create: bool = False,
        study: str | None = None,
        say: Callable[[str], None] = lambda text: None,
        clock: _MachineClock | None = None,
    ) -> None:
        """Open the store of a folder. create: when the first session begins, and none before.

        study: name that the store must have; None for any. say: receives notes for the user.
        """
        folder = Path(folder)
        self.folder, self.traces = folder, folder / TRACES
        self._path, self._say, self._clock = folder / DATABASE, say, clock or _MachineClock()
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

    # --- sessions ---

    def begin(
        self,
        design: Design,
        part: str | None,
        code: str,
        origin: str,
        new_session: bool = False,
        facts: Mapping[str, Any] | None = None,
    ) -> Session:
        """Begin a session with the next order; return it, running.

        code: the participant's; "new" draws one. origin: one of ORIGINS. new_session: the
        participant must be known instead of unknown.
        Errors: InputError for a code that is invalid, known (or unknown, with new_session),
        withdrawn or of another origin; for an unknown part; for a plan whose signature differs from
        that of earlier sessions (admission.check_plan).
        """
        part = admission.chosen_part(design, part)
        if not self.name:
            admission.check_first(code, new_session)  # before a folder is created
        self._take_lock(design.name)
        with self._write() as db:
            participant = admission.participant_for(db, code, part, origin, new_session)
            mended = admission.check_plan(db, design, part, origin)
            id_ = admission.new_session(db, design, part, participant, origin, facts or {}, self._now())
            session = records.session(db, id_)
            data = {"part": part, "row": session.row, "plan_text_changed": mended}
            if design.consent is not None:  # it may be in its own file, which the plan's text does not hold
                digest = hashlib.sha256(design.consent.text.encode()).hexdigest()
                data |= {"consent_version": design.consent.version, "consent_sha256": digest}
            self._event(session, "begin", data=data)
            session = records.session(db, id_)  # which the event tells whether it needs a consent
        if mended:
            self._say(
                "the study's file changed since the last session, but not what it shows and asks; both texts are kept"
            )
        return session

    def would_begin(self, design: Design, part: str | None, code: str, origin: str, new_session: bool = False) -> None:
        """Raise what `begin` would refuse, before anybody puts a headset on; creates nothing."""
        part = admission.chosen_part(design, part)
        if not self.name:
            admission.check_first(code, new_session)
            database.check_place(self.folder)
            return
        self._take_lock(design.name)
        with suppress(_Undone), self._write() as db:
            admission.participant_for(db, code, part, origin, new_session)
            admission.check_plan(db, design, part, origin)
            raise _Undone

    def would_resume(self, code: str, part: str | None = None) -> Session:
        """Return the session that `resume` would resume. Errors: as resume."""
        self._take_lock()
        with translated(self._path):
            return admission.to_resume(self._db, code, part)

    def check_same(self, session: Session, design: Design) -> None:
        """Raise InputError where `design`, read from the session's plan, has a new signature."""
        with translated(self._path):
            admission.check_same(self._db, design, session)

    def resume(self, code: str, part: str | None = None, facts: Mapping[str, Any] | None = None) -> Session:
        """Resume a participant's interrupted session. facts: of this run of the program."""
        self._take_lock()
        with self._write() as db:
            session = admission.to_resume(db, code, part)
            db.execute(
                "UPDATE session SET status = ?, ended_utc = '', why = '' WHERE id = ?", (records.RUNNING, session.id)
            )
            self._event(session, "resume", data=facts or {})
            if not records.passed_s(db, session.id)[1]:
                self._say(
                    "the machine's clock was set back between two runs of this session: onsets count from its "
                    "beginning without the time between them"
                )
            return records.session(db, session.id)

    def end(self, session: Session, status: str, why: str = "") -> Session:
        """End a session with one of STATUSES but RUNNING, and renew the copy of the store.

        why: in words. DECLINED needs "refused" in the journal; a session that is STOPPED before its
        consent was given is returned as UNCONSENTED.
        """
        if status not in records.STATUSES or status in (records.RUNNING, records.UNCONSENTED):
            raise ValueError(f"a session does not end as {status!r}")
        with self._running(session) as db:
            self._event(session, "end", data={"status": status, "why": why})
            now = self._now()
            db.execute(
                "UPDATE session SET status = ?, ended_utc = ?, why = ? WHERE id = ?",
                (records.STOPPED if status == records.DECLINED else status, now, clean(why), session.id),
            )
            ended = records.session(db, session.id)
            if (ended.status == records.DECLINED) != (status == records.DECLINED):
                raise ValueError(f"a session cannot end as {status!r}: its journal says {ended.status!r}")
        self._copy(told=status != records.INTERRUPTED)  # what interrupted it, such as a full disk, has its own line
        return ended

    def record(self, session: Session, kind: str, key: str = "", **data: Any) -> None:
        """Record an event. data: as JSON can hold, and NumPy's numbers; NaN becomes null."""
        with self._running(session):
            self._event(session, kind, key, data)

    def finish_step(self, session: Session, key: str) -> None:
        """Record that the participant agreed to a Read, or that a Pause is over."""
        self.record(session, "finished", key)

    def begin_showing(
        self, session: Session, step: Show, settings: Mapping[str, Any], recorded: bool = True
    ) -> Showing:
        """Record a showing before its first picture. recorded: there will be a trace."""
        with self._running(session) as db:
            query = "SELECT coalesce(max(presentation), 0) + 1 FROM showing WHERE session = ? AND key = ?"
            presentation = db.execute(query, (session.id, step.key)).fetchone()[0]
            trace = self.path_for(session, step, presentation).name if recorded else ""
            id_ = admission.insert(
                db, "showing", session=session.id, key=step.key, trial=step.trial, repeat=step.repeat,
                condition=step.condition.name, presentation=presentation, settings=to_json(settings), trace=trace,
                started_utc=self._now(),
            )  # fmt: skip
            told = {"showing": id_, "presentation": presentation}
            self._event(session, "showing", step.key, told)
            return records.showing(db, id_)

    def end_showing(self, session: Session, showing: Showing, actual: Mapping[str, Any], complete: bool) -> Showing:
        """Record the end of a showing, after its trace is closed; a missing file is no trace."""
        trace = showing.trace if showing.trace and database.sync_trace(self.traces / showing.trace) else ""
        with self._running(session) as db:
            values = (int(complete), to_json(actual), trace, showing.id, session.id)
            db.execute("UPDATE showing SET complete = ?, actual = ?, trace = ? WHERE id = ? AND session = ?", values)
            told = {"showing": showing.id, "complete": complete}
            self._event(session, "shown", showing.key, told)
            return records.showing(db, showing.id)

    def answer(
        self,
        session: Session,
        step: Ask,
        value: float | None,
        seconds: float,
        by: str,
        showing: Showing | int | None = None,
        text: str = "",
    ) -> Answer:
        """Record a confirmed answer; another one to the same question is a new revision.

        value: None for "cannot say", and for an answer in words, which are `text`; the journal has
        them. seconds: since the question appeared. by: "participant",
        "experimenter" or "simulated".
        """
        if value is not None and not math.isfinite(value):
            raise ValueError(f"an answer of {value} to {step.key}")
        with self._running(session) as db:
            query = "SELECT coalesce(max(revision), 0) + 1 FROM answer WHERE session = ? AND key = ?"
            revision = db.execute(query, (session.id, step.key)).fetchone()[0]
            id_ = admission.insert(
                db, "answer", session=session.id, key=step.key, revision=revision, phase=step.phase, trial=step.trial,
                scale=step.scale.name, item=step.item.key, value=value, seconds=float(seconds), answered_by=by,
                at_utc=self._now(), showing=showing.id if isinstance(showing, Showing) else showing,
            )  # fmt: skip
            words = {"text": text} if text else {}
            self._event(session, "answer", step.key, {"value": value, "revision": revision, **words})
            return records.answer(db, id_)

    # --- data ---

    def done(self, session: Session) -> set[str]:
        """Return the keys of answered Asks, complete Shows, and steps of finish_step."""
        with translated(self._path):
            query = """SELECT key FROM answer WHERE session = :id
              UNION SELECT key FROM showing WHERE session = :id AND complete
              UNION SELECT key FROM event WHERE session = :id AND kind = 'finished'"""
            return {key for (key,) in self._db.execute(query, {"id": session.id})}

    def passed_s(self, session: Session) -> float:
        """Return the time since a session began, less gaps over which the clock was set back."""
        with translated(self._path):
            return records.passed_s(self._db, session.id)[0]

    def answers(self, session: Session) -> tuple[Answer, ...]:
        """Return the last answer to each question, in the order of the first answers."""
        with translated(self._path):
            return records.last_answers(self._db, session.id)

    def contents(self, pilot: bool = False) -> Contents:
        """Return all data of one moment: of people (or simulated participants), or of pilots."""
        with translated(self._path):
            return records.contents(self._db, self.folder, pilot)

    def path_for(self, session: Session, step: Show, presentation: int) -> Path:
        """Return the path of a head trace; of a trial 0, the practice, too."""
        which = f"{step.trial}-{step.turn}" if step.turn else f"{step.trial}"
        return self.traces / f"{session.sub}_ses-{session.number}_trial-{which}_{presentation}.csv"

    def measured(self, showing_id: int, data: Mapping[str, Any]) -> None:
        """Replace the figures measured of a showing's pictures; holds the lock as long."""
        locked = self._take_lock()
        try:
            with self._write() as db:
                change = "UPDATE showing SET measured = ? WHERE id = ?"
                if db.execute(change, (to_json(data), showing_id)).rowcount != 1:
                    raise KeyError(showing_id)
        finally:
            if locked:
                self.close()
                self._open = database.open_to_read(self.folder)

    def holdings(self, code: str) -> Holdings:
        """Return the amount of data to erase. Errors: InputError, as withdraw."""
        with translated(self._path):
            participant, sub = known(self._db, code)
            query = "SELECT code FROM participant WHERE id = ?"  # as it was first written: searches ignore case
            code = str(self._db.execute(query, (participant,)).fetchone()[0])
            of = "WHERE session IN (SELECT id FROM session WHERE participant = ?)"
            tables = {"sessions": "session WHERE participant = ?"}
            tables |= {f"{table}s": f"{table} {of}" for table in ("answer", "showing", "event")}
            counted = {
                name: self._db.execute(f"SELECT count(*) FROM {rows}", (participant,)).fetchone()[0]
                for name, rows in tables.items()
            }
        files = [path for path in self.traces.glob(f"*{sub}*") if path.is_file()]
        size = sum(path.stat().st_size for path in files)
        return Holdings(code, sub, **counted, traces=database.count_of_traces(files), bytes=size)

    def finish_withdrawal(self, code: str) -> bool:
        """Return whether an interrupted withdrawal of this participant ended just now."""
        self._take_lock()
        return code.lower() in [finished.lower() for finished in self._finished]

    def withdraw(self, code: str) -> Holdings | None:
        """Erase all data of a participant but the code, at any time and without a reason.

        Returns what was erased, None for an interrupted withdrawal. Errors: InputError for unknown
        or withdrawn codes; MachineError while a session runs or a reader keeps the old bytes alive.
        """
        if self.finish_withdrawal(code):
            return None
        erased = self.holdings(code)
        erase(self._db, self.folder, code)
        self._copy()
        return erased

    # --- the connection ---

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
        return "" if self._open is None else records.study_name(self._open)

    @property
    def _db(self) -> sqlite3.Connection:
        if self._open is None:
            raise InputError(f"{self.folder}: {NOTHING} yet: run a session first")
        return self._open

    def _take_lock(self, study: str | None = None) -> bool:
        """Take the lock to write, unless it is held. study: its name, or no store is created."""
        self._check_name(study)
        if self._lock is not None:
            return False
        if self._create and study:
            database.make_folders(self.folder)
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

    def _tidy(self) -> None:
        """Mark sessions of dead programs as interrupted, and finish interrupted withdrawals."""
        self._finished = finish_erasing(self._db, self.folder)
        for code in self._finished:
            self._say(f"the withdrawal of participant {code} was interrupted; it is finished now")
            self._copy()
        died = [id_ for (id_,) in self._db.execute("SELECT id FROM session WHERE status = ?", (records.RUNNING,))]
        with self._write() as db:
            for id_ in died:
                self._event(records.session(db, id_), "interrupted", data={"why": "the program died"})
                db.execute("UPDATE session SET status = ? WHERE id = ?", (records.INTERRUPTED, id_))

    def _copy(self, *, told: bool = True) -> None:
        """Renew the copy; that it fails costs no session. told: whether it says so."""
        try:
            database.write_copy(self._db, self.folder)
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
        """Open a transaction of a running session. Errors: HmdwarpError where it is over."""
        with self._write() as db:
            now = records.session(db, session.id)
            if now.status != records.RUNNING:
                raise HmdwarpError(
                    f"session {now.number} of participant {now.code} is {now.status}: nothing more can be stored in it"
                )
            yield db

    def _now(self) -> str:
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
        before = now if latest is None else latest[0]
        back_s = (datetime.fromisoformat(before) - datetime.fromisoformat(now)).total_seconds()
        if back_s >= BACK_S:
            # No time of another session: this entry stays when that session's participant
            # withdraws.
            noted = {"before": before, "back_s": back_s} if latest[1] == session.id else {}
            self._db.execute(insert, (session.id, "clock", "", now, mono_ns, to_json(noted)))
            self._say(
                f"the machine's clock was set back by {back_s:.0f} s: nothing is lost; the order of the data does "
                "not depend on it"
            )
        self._db.execute(insert, (session.id, kind, key, now, mono_ns, to_json(data or {})))
