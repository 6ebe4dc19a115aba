"""The store of a study: every event is on the disk when the call that tells it returns.

SQLite and not a log that is only appended to, because
* withdrawal must erase in the middle: a log would have to be written anew, and to be right at every instant of that;
* guards against a doubled rating are part of the file (UNIQUE over session, question and revision), not of the program that writes it;
* an event, the row it makes and the order it takes up are one transaction: there is no state in between to come back to after a crash;
* an export may read while a session writes.
WAL with synchronous=FULL: a commit returns after an fsync. One writer at a time, by a lock of the kernel's that goes with the program.
"""

from __future__ import annotations

import math
import sqlite3
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ...errors import InputError
from ...version import __version__
from ..design import Design
from ..steps import Ask, Show
from . import beginning, reading, schema
from ._json import to_json
from .clock import Clock, MachineClock, seconds_back, text_of
from .erasing import erase, finish_erasing
from .faults import told, transaction
from .folders import TRACES, make_folders, trace_name
from .lock import Lock
from .nouns import INTERRUPTED, RUNNING, STATUSES, Answer, Contents, Session, Showing

BACK_S = 1.0  # less is a clock being set right by the network, and no order depends on it


class Store:
    """The data of one study, in a folder. Use as a context manager.

    folder: see folders.store_folder. create: make it where there is none; study: whose it is then, and must be. say: gets a sentence now
    and then. Opened for reading, which needs no lock; the first call that writes takes it, until the store is closed.
    Errors, of every method too: InputError and MachineError, as faults.store_error and lock.Lock say.
    """

    def __init__(
        self,
        folder: Path,
        create: bool = False,
        study: str | None = None,
        say: Callable[[str], None] = lambda text: None,
        clock: Clock | None = None,
    ) -> None:
        self.folder, self._say, self._clock = Path(folder), say, clock or MachineClock()
        self.path, self.traces = self.folder / schema.FILE, self.folder / TRACES
        self._lock: Lock | None = None
        self._create, self._study = create, study
        self._db: sqlite3.Connection | None = None
        if not schema.is_made(self.folder):
            if not create:
                raise InputError(f"{self.folder}: no data of a study there (no {schema.FILE}): run a session first, or give --store")
            return  # made by the first session, which knows the study's name: a session refused before leaves nothing behind
        self._db = schema.open_to_read(self.folder)
        self._check_name(study)

    def __enter__(self) -> Store:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Let go of everything. May be called twice. A session that is not ended may be resumed."""
        if self._db is not None:
            self._db.close()
            self._db = None
        if self._lock is not None:
            self._lock.close()
            self._lock = None

    @property
    def name(self) -> str:
        """The study's; "" before there is anything."""
        return "" if self._db is None else reading.study_name(self._db)

    # --- a session ------------------------------------------------------------------------------------------------------

    def begin(
        self,
        design: Design,
        part: str | None,
        code: str,
        origin: str,
        new_session: bool = False,
        facts: Mapping[str, Any] | None = None,
    ) -> Session:
        """A new session, running, with the order whose turn it is.

        code: the participant's; "new" draws one. origin: of ORIGINS. new_session: whether the participant must be known instead of unknown.
        Errors: InputError for a code that is none, is known (or unknown, with new_session), withdrew, or is of another origin; for a part
        that is none; for a plan whose meaning is another than that of the sessions before (beginning.check_plan).
        """
        part = beginning.the_part(design, part)
        self._lock_for(design.name)
        with self._transaction() as db:
            participant = beginning.participant_for(db, code, part, origin, new_session)
            mended = beginning.check_plan(db, design, part, origin)
            now = text_of(self._clock.utc())
            id_ = beginning.new_session(db, design, part, participant, origin, facts or {}, now)
            session = reading.session(db, id_)
            self._event(db, session, "begin", data={"part": part, "row": session.row, "plan_text_changed": mended})
        if mended:
            self._say("the study's file is another than in the session before, but shows and asks the same; both are kept")
        return session

    def resume(self, code: str, part: str | None = None, facts: Mapping[str, Any] | None = None) -> Session:
        """Go on with the interrupted session of a participant. facts: of this run of the program, kept with the event.

        Errors: InputError where there is none, or several parts have one and none is named.
        """
        self._lock_for(None)
        with self._transaction() as db:
            session = beginning.to_resume(db, code, part)
            db.execute("UPDATE session SET status = ?, ended_utc = '', why = '' WHERE id = ?", (RUNNING, session.id))
            self._event(db, session, "resume", data=facts or {})
            return reading.session(db, session.id)

    def end(self, session: Session, status: str, why: str = "") -> Session:
        """status: any of STATUSES but RUNNING. why: in words, "" where nobody must give a reason."""
        if status not in STATUSES or status == RUNNING:
            raise ValueError(f"a session does not end as {status!r}")
        with self._going_on(session) as db:
            self._event(db, session, "end", data={"status": status, "why": why})
            now = text_of(self._clock.utc())
            db.execute("UPDATE session SET status = ?, ended_utc = ?, why = ? WHERE id = ?", (status, now, why, session.id))
            return reading.session(db, session.id)

    def record(self, session: Session, kind: str, key: str = "", **data: Any) -> None:
        """Any event. data: what JSON can hold; NumPy's numbers too, NaN becomes null."""
        with self._going_on(session) as db:
            self._event(db, session, kind, key, data)

    def finish_step(self, session: Session, key: str) -> None:
        """A Read was agreed to, a Pause is over."""
        self.record(session, "finished", key)

    def begin_showing(self, session: Session, step: Show, settings: Mapping[str, Any], recorded: bool = True) -> Showing:
        """Before the first picture. Where the program dies from here on, the showing stays, incomplete, with as much trace as there is.

        recorded: whether there will be a trace, at traces / showing.trace, a name that was never used.
        """
        with self._going_on(session) as db:
            query = "SELECT coalesce(max(presentation), 0) + 1 FROM showing WHERE session = ? AND key = ?"
            presentation = db.execute(query, (session.id, step.key)).fetchone()[0]
            trace = self.path_for(session, step, presentation).name if recorded else ""
            id_ = db.execute(
                """INSERT INTO showing (session, key, trial, repeat, condition, presentation, settings, trace, started_utc)
                  VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)""",
                (session.id, step.key, step.trial, step.repeat, step.condition.name, presentation, to_json(settings), trace,
                 text_of(self._clock.utc())),
            ).lastrowid  # fmt: skip
            self._event(db, session, "showing", step.key, {"showing": id_, "presentation": presentation})
            return reading.showing(db, id_)

    def end_showing(self, session: Session, showing: Showing, actual: Mapping[str, Any], complete: bool) -> Showing:
        """After the last picture, and after the trace was closed: one that has nothing in it (no file) is none. actual: see study/run."""
        trace = showing.trace if showing.trace and (self.traces / showing.trace).is_file() else ""
        with self._going_on(session) as db:
            values = (int(complete), to_json(actual), trace, showing.id, session.id)
            db.execute("UPDATE showing SET complete = ?, actual = ?, trace = ? WHERE id = ? AND session = ?", values)
            self._event(db, session, "shown", showing.key, {"showing": showing.id, "complete": complete})
            return reading.showing(db, showing.id)

    def shown(
        self, session: Session, step: Show, settings: Mapping[str, Any], trace: bool, actual: Mapping[str, Any], complete: bool
    ) -> Showing:
        """Both at once, for what takes no time. trace: whether there is one."""
        return self.end_showing(session, self.begin_showing(session, step, settings, recorded=trace), actual, complete)

    def answer(
        self, session: Session, step: Ask, value: float | None, seconds: float, by: str, showing: Showing | int | None = None
    ) -> Answer:
        """A confirmed answer; a further one to the same question is a new revision, and both are kept.

        value: None for "cannot say". seconds: since the question came. by: "participant", "experimenter", "simulated".
        """
        if value is not None and not math.isfinite(value):
            raise ValueError(f"an answer of {value} to {step.key}")
        with self._going_on(session) as db:
            query = "SELECT coalesce(max(revision), 0) + 1 FROM answer WHERE session = ? AND key = ?"
            revision = db.execute(query, (session.id, step.key)).fetchone()[0]
            self._event(db, session, "answer", step.key, {"value": value, "revision": revision})
            id_ = db.execute(
                """INSERT INTO answer (session, key, revision, phase, trial, scale, item, value, seconds, answered_by, at_utc, showing)
                  VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)""",
                (session.id, step.key, revision, step.phase, step.trial, step.scale.name, step.item.key, value, float(seconds), by,
                 text_of(self._clock.utc()), showing.id if isinstance(showing, Showing) else showing),
            ).lastrowid  # fmt: skip
            return reading.answer(db, id_)

    # --- what there is --------------------------------------------------------------------------------------------------

    def done(self, session: Session) -> set[str]:
        """Keys of the steps that are over: answered Asks, complete Shows, and those finish_step was told of."""
        with told(self.path):
            return reading.done(self._reader(), session.id)

    def answers(self, session: Session) -> tuple[Answer, ...]:
        """Those that count, one for each question, in the order the questions were first answered."""
        with told(self.path):
            return reading.counting(self._reader(), session.id)

    def contents(self, pilot: bool = False) -> Contents:
        """Everything of one moment, every revision and every showing: of people (or simulated ones), or of pilots."""
        with told(self.path):
            return reading.contents(self._reader(), self.folder, pilot)

    def path_for(self, session: Session, step: Show, presentation: int) -> Path:
        """Of the head's trace."""
        return self.traces / trace_name(session.sub, session.number, step.trial, presentation)

    def measured(self, showing_id: int, data: Mapping[str, Any]) -> None:
        """What was found out about a showing's pictures afterwards, in place of what was found before. The lock is held for a moment."""
        held = self._lock is not None
        self._lock_for(None)
        try:
            with self._transaction() as db:
                changed = db.execute("UPDATE showing SET measured = ? WHERE id = ?", (to_json(data), showing_id)).rowcount
                if changed != 1:
                    raise KeyError(showing_id)
        finally:
            if not held:
                self._unlock()

    def withdraw(self, code: str) -> None:
        """Erase all that is there of a participant but the code; study/withdraw.py tells more. Errors: InputError for an unknown code."""
        self._lock_for(None)
        erase(self._writer(), self.folder, code)

    # --- inside ---------------------------------------------------------------------------------------------------------

    def _lock_for(self, study: str | None) -> None:
        """Become the one who writes. study: its name, where a new store may be made."""
        if self._lock is not None:
            self._check_name(study)
            return
        if self._db is None and not (self._create and study):
            raise InputError(f"{self.folder}: there are no data of a study there: run a session first, or give --store")
        if self._create:
            make_folders(self.folder)
        lock = Lock(self.folder, self._clock.utc())
        try:
            if not schema.is_made(self.folder):
                schema.make(self.folder, study or "", __version__)
            db = schema.open_to_write(self.folder)
        except BaseException:
            lock.close()
            raise
        if self._db is not None:
            self._db.close()
        self._db, self._lock = db, lock
        self._check_name(study)
        self._tidy()

    def _unlock(self) -> None:
        self.close()
        self._db = schema.open_to_read(self.folder)

    def _tidy(self) -> None:
        """With the lock there is nobody else: what still runs is of a program that died, and a withdrawal that is not over ends now."""
        finish_erasing(self._writer(), self.folder)
        with self._transaction() as db:
            for id_ in reading.ids(db.execute("SELECT id FROM session WHERE status = ?", (RUNNING,)).fetchall()):
                self._event(db, reading.session(db, id_), "interrupted", data={"why": "the program ended without a word"})
                db.execute("UPDATE session SET status = ? WHERE id = ?", (INTERRUPTED, id_))

    def _check_name(self, study: str | None) -> None:
        wanted = study or self._study
        if wanted and self.name and self.name != wanted:
            raise InputError(f"{self.folder}: holds the study '{self.name}', not '{wanted}': choose another folder (--store)")

    def _reader(self) -> sqlite3.Connection:
        if self._db is None:
            raise InputError(f"{self.folder}: there are no data of a study there yet")
        return self._db

    def _writer(self) -> sqlite3.Connection:
        assert self._lock is not None, "nothing is written without the lock"
        return self._reader()

    @contextmanager
    def _transaction(self) -> Iterator[sqlite3.Connection]:
        with transaction(self._writer(), self.path) as db:
            yield db

    @contextmanager
    def _going_on(self, session: Session) -> Iterator[sqlite3.Connection]:
        """A transaction of a session that is running."""
        with self._transaction() as db:
            now = reading.session(db, session.id)
            if now.status != RUNNING:
                raise beginning.not_running(now)
            yield db

    def _event(self, db: sqlite3.Connection, session: Session, kind: str, key: str = "", data: Mapping[str, Any] | None = None) -> None:
        now = text_of(self._clock.utc())
        latest = db.execute("SELECT at_utc FROM event ORDER BY id DESC LIMIT 1").fetchone()
        insert = "INSERT INTO event (session, kind, key, at_utc, mono_ns, data) VALUES (?, ?, ?, ?, ?, ?)"
        if latest is not None and (back_s := seconds_back(latest[0], now)) >= BACK_S:
            db.execute(insert, (session.id, "clock", "", now, self._clock.mono_ns(), to_json({"before": latest[0], "back_s": back_s})))
            self._say(f"the machine's clock was set back by {back_s:.0f} s: nothing is lost, what is stored is in order without it")
        db.execute(insert, (session.id, kind, key, now, self._clock.mono_ns(), to_json(data or {})))
