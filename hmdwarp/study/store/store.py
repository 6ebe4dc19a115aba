"""The store of a study: every event is on the disk when the call that tells it returns.

SQLite and not a log that is only appended to, because
* withdrawal must erase in the middle: a log would have to be written anew, and to be right at every instant of that;
* guards against a doubled rating are part of the file (UNIQUE over session, question and revision), not of the program that writes it;
* an event, the row it makes and the order it takes up are one transaction: there is no state in between to come back to after a crash;
* an export may read while a session writes.
WAL with synchronous=FULL: a commit returns after an fsync. One writer at a time, by a lock of the kernel's that goes with the program.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from ..design import Ask, Design, Show
from . import beginning, reading
from ._json import clean, to_json
from .clock import Clock, MachineClock
from .erasing import erase, known
from .faults import told
from .folders import check_place, sync_trace, trace_name
from .nouns import RUNNING, STATUSES, Answer, Contents, Session, Showing
from .opened import Opened


class _Undone(Exception):  # noqa: N818 (nothing is wrong: a transaction is given up)
    """What was only tried must not stay."""


class Store:
    """The data of one study, in a folder. Use as a context manager.

    folder: see folders.store_folder. create: make it where there is none, when the first session begins; a session that is refused
    leaves nothing behind. study: whose it must be, None for anybody's. say: gets a sentence now and then. Opened for reading, which needs
    no lock; the first call that writes takes it, until the store is closed.
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
        self._opened = Opened(Path(folder), create, study, say, clock or MachineClock())
        self.folder, self.traces = self._opened.folder, self._opened.traces

    def __enter__(self) -> Store:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Let go of everything. May be called twice. A session that is not ended may be resumed."""
        self._opened.close()

    @property
    def name(self) -> str:
        """The study's; "" before there is anything."""
        return self._opened.name

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
        if not self._opened.name:
            beginning.check_first(code, new_session)  # before a folder is made
        self._opened.lock(design.name)
        with self._opened.write() as db:
            participant = beginning.participant_for(db, code, part, origin, new_session)
            mended = beginning.check_plan(db, design, part, origin)
            now = self._opened.now()
            id_ = beginning.new_session(db, design, part, participant, origin, facts or {}, now)
            session = reading.session(db, id_)
            data = {"part": part, "row": session.row, "plan_text_changed": mended, **_consent(design)}
            self._opened.event(session, "begin", data=data)
        if mended:
            self._opened.say(
                "the study's file is another than in the session before, but shows and asks the same; both are kept"
            )
        return session

    def would_begin(self, design: Design, part: str | None, code: str, origin: str, new_session: bool = False) -> None:
        """Nothing, or what `begin` would refuse: to be told before anybody puts a headset on. A store that is not there yet is not made."""
        part = beginning.the_part(design, part)
        if not self._opened.name:
            beginning.check_first(code, new_session)
            check_place(self.folder)
            return
        self._opened.lock(design.name)
        with suppress(_Undone), self._opened.write() as db:
            beginning.participant_for(db, code, part, origin, new_session)
            beginning.check_plan(db, design, part, origin)
            raise _Undone

    def would_resume(self, code: str, part: str | None = None) -> Session:
        """The session that `resume` would go on with. Errors: as resume."""
        self._opened.lock()
        with told(self._opened.path):
            return beginning.to_resume(self._opened.db, code, part)

    def check_same(self, session: Session, design: Design) -> None:
        """Errors: InputError where `design`, read from the session's plan, means something else than it did when the session began."""
        with told(self._opened.path):
            beginning.check_same(self._opened.db, design, session)

    def resume(self, code: str, part: str | None = None, facts: Mapping[str, Any] | None = None) -> Session:
        """Go on with the interrupted session of a participant. facts: of this run of the program, kept with the event.

        Errors: InputError where there is none, or several parts have one and none is named.
        """
        self._opened.lock()
        with self._opened.write() as db:
            session = beginning.to_resume(db, code, part)
            db.execute("UPDATE session SET status = ?, ended_utc = '', why = '' WHERE id = ?", (RUNNING, session.id))
            self._opened.event(session, "resume", data=facts or {})
            return reading.session(db, session.id)

    def end(self, session: Session, status: str, why: str = "") -> Session:
        """status: any of STATUSES but RUNNING. why: in words, "" where nobody must give a reason."""
        if status not in STATUSES or status == RUNNING:
            raise ValueError(f"a session does not end as {status!r}")
        with self._opened.going_on(session) as db:
            self._opened.event(session, "end", data={"status": status, "why": why})
            now = self._opened.now()
            db.execute(
                "UPDATE session SET status = ?, ended_utc = ?, why = ? WHERE id = ?",
                (status, now, clean(why), session.id),
            )
            return reading.session(db, session.id)

    def record(self, session: Session, kind: str, key: str = "", **data: Any) -> None:
        """Any event. data: what JSON can hold; NumPy's numbers too, NaN becomes null."""
        with self._opened.going_on(session):
            self._opened.event(session, kind, key, data)

    def finish_step(self, session: Session, key: str) -> None:
        """A Read was agreed to, a Pause is over."""
        self.record(session, "finished", key)

    def begin_showing(
        self, session: Session, step: Show, settings: Mapping[str, Any], recorded: bool = True
    ) -> Showing:
        """Before the first picture. Where the program dies from here on, the showing stays, incomplete, with as much trace as there is.

        recorded: whether there will be a trace, at traces / showing.trace, a name that was never used.
        """
        with self._opened.going_on(session) as db:
            query = "SELECT coalesce(max(presentation), 0) + 1 FROM showing WHERE session = ? AND key = ?"
            presentation = db.execute(query, (session.id, step.key)).fetchone()[0]
            trace = self.path_for(session, step, presentation).name if recorded else ""
            id_ = db.execute(
                """INSERT INTO showing (session, key, trial, repeat, condition, presentation, settings, trace, started_utc)
                  VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)""",
                (session.id, step.key, step.trial, step.repeat, step.condition.name, presentation, to_json(settings), trace,
                 self._opened.now()),
            ).lastrowid  # fmt: skip
            self._opened.event(session, "showing", step.key, {"showing": id_, "presentation": presentation})
            return reading.showing(db, id_)

    def end_showing(self, session: Session, showing: Showing, actual: Mapping[str, Any], complete: bool) -> Showing:
        """After the last picture, and after the trace was closed: one that has nothing in it (no file) is none. actual: see study/run."""
        trace = showing.trace if showing.trace and sync_trace(self.traces / showing.trace) else ""
        with self._opened.going_on(session) as db:
            values = (int(complete), to_json(actual), trace, showing.id, session.id)
            db.execute("UPDATE showing SET complete = ?, actual = ?, trace = ? WHERE id = ? AND session = ?", values)
            self._opened.event(session, "shown", showing.key, {"showing": showing.id, "complete": complete})
            return reading.showing(db, showing.id)

    def shown(
        self,
        session: Session,
        step: Show,
        settings: Mapping[str, Any],
        trace: bool,
        actual: Mapping[str, Any],
        complete: bool,
    ) -> Showing:
        """Both at once, for what takes no time. trace: whether there is one."""
        return self.end_showing(session, self.begin_showing(session, step, settings, recorded=trace), actual, complete)

    def answer(
        self,
        session: Session,
        step: Ask,
        value: float | None,
        seconds: float,
        by: str,
        showing: Showing | int | None = None,
    ) -> Answer:
        """A confirmed answer; a further one to the same question is a new revision, and both are kept.

        value: None for "cannot say". seconds: since the question came. by: "participant", "experimenter", "simulated".
        """
        if value is not None and not math.isfinite(value):
            raise ValueError(f"an answer of {value} to {step.key}")
        with self._opened.going_on(session) as db:
            query = "SELECT coalesce(max(revision), 0) + 1 FROM answer WHERE session = ? AND key = ?"
            revision = db.execute(query, (session.id, step.key)).fetchone()[0]
            self._opened.event(session, "answer", step.key, {"value": value, "revision": revision})
            id_ = db.execute(
                """INSERT INTO answer (session, key, revision, phase, trial, scale, item, value, seconds, answered_by, at_utc, showing)
                  VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)""",
                (session.id, step.key, revision, step.phase, step.trial, step.scale.name, step.item.key, value, float(seconds), by,
                 self._opened.now(), showing.id if isinstance(showing, Showing) else showing),
            ).lastrowid  # fmt: skip
            return reading.answer(db, id_)

    # --- what there is --------------------------------------------------------------------------------------------------

    def done(self, session: Session) -> set[str]:
        """Keys of the steps that are over: answered Asks, complete Shows, and those finish_step was told of."""
        with told(self._opened.path):
            return reading.done(self._opened.db, session.id)

    def answers(self, session: Session) -> tuple[Answer, ...]:
        """Those that count, one for each question, in the order the questions were first answered."""
        with told(self._opened.path):
            return reading.counting(self._opened.db, session.id)

    def contents(self, pilot: bool = False) -> Contents:
        """Everything of one moment, every revision and every showing: of people (or simulated ones), or of pilots."""
        with told(self._opened.path):
            return reading.contents(self._opened.db, self.folder, pilot)

    def path_for(self, session: Session, step: Show, presentation: int) -> Path:
        """Of the head's trace."""
        return self.traces / trace_name(session.sub, session.number, step.trial, presentation)

    def measured(self, showing_id: int, data: Mapping[str, Any]) -> None:
        """What was found out about a showing's pictures afterwards, in place of what was found before. The lock is held for a moment."""
        locked = self._opened.lock()
        try:
            with self._opened.write() as db:
                changed = db.execute(
                    "UPDATE showing SET measured = ? WHERE id = ?", (to_json(data), showing_id)
                ).rowcount
                if changed != 1:
                    raise KeyError(showing_id)
        finally:
            if locked:
                self._opened.unlock()

    def lock(self) -> list[str]:
        """Become the one who writes, if not so already. The codes whose withdrawal had been cut off and ended just then."""
        self._opened.lock()
        return self._opened.finished

    def holdings(self, code: str) -> tuple[str, str, dict[str, int]]:
        """A participant's code as it was first written, the sub, and how many rows there are, by kind. Errors: InputError for one who is
        not known or has withdrawn."""
        with told(self._opened.path):
            participant, sub = known(self._opened.db, code)
            return reading.code_of(self._opened.db, participant), sub, reading.counts(self._opened.db, participant)

    def withdraw(self, code: str) -> None:
        """Erase all that is there of a participant but the code; study/withdraw.py tells more. Errors: InputError for an unknown code."""
        self._opened.lock()
        erase(self._opened.db, self.folder, code)


def _consent(design: Design) -> dict[str, str]:
    """Which text was there to be agreed to: it may lie in a file of its own, which the plan's text does not hold."""
    if design.consent is None:
        return {}
    return {
        "consent_version": design.consent.version,
        "consent_sha256": hashlib.sha256(design.consent.text.encode()).hexdigest(),
    }
