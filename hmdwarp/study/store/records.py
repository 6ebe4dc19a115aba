"""Rows of the store as frozen objects, and how they are read."""

from __future__ import annotations

import itertools
import json
import math
import sqlite3
from collections.abc import Mapping
from datetime import datetime
from pathlib import Path
from typing import Any

import attrs


def to_json(data: Mapping[str, Any]) -> str:
    """Encode data; NaN and infinite numbers become null, NumPy's plain. Errors: TypeError."""
    return json.dumps(_plain(data), ensure_ascii=False, allow_nan=False, separators=(",", ":"))


class DamagedRow(sqlite3.DatabaseError):
    """A row is not as it was written, which SQLite cannot know."""

    sqlite_errorname = "SQLITE_CORRUPT"


def from_json(text: str) -> Any:
    """Decode a text that to_json wrote. Errors: DamagedRow."""
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:
        raise DamagedRow(f"no JSON in {text[:20]!r}") from error


def dict_in(text: str) -> dict[str, Any]:
    """Decode a row's data, without the checksum of stores of 0.2. Errors: DamagedRow."""
    data = from_json(text)
    if not isinstance(data, dict):
        raise DamagedRow(f"no data in {text[:20]!r}")
    data.pop("seal", None)
    return data


def clean(text: str) -> str:
    """Replace lone surrogates, a terminal's broken bytes, by "?": the database refuses them."""
    return text.encode(errors="replace").decode()


def _plain(value: Any) -> Any:
    if hasattr(value, "tolist"):  # NumPy's
        value = value.tolist()
    if isinstance(value, Mapping):
        return {clean(str(key)): _plain(held) for key, held in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [_plain(held) for held in value]
    if isinstance(value, str | Path):
        return clean(str(value))
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if value is None or isinstance(value, bool | int):
        return value
    raise TypeError(f"{type(value).__name__} cannot be stored: {value!r}")


ORIGINS = (PERSON, PILOT, SIMULATED) = ("person", "pilot", "simulated")
STATUSES = (RUNNING, INTERRUPTED, COMPLETE, STOPPED, SICK, DECLINED, UNCONSENTED) = (
    *("running", "interrupted", "complete", "stopped", "sick", "declined", "unconsented"),
)
# RUNNING: now, or its program died. INTERRUPTED: may be resumed. STOPPED: by the participant or the
# experimenter, without a reason. SICK: by the stop rule. DECLINED: the consent was refused;
# UNCONSENTED: stopped before it was given. Neither took part: they count nowhere. The last
# five are over.


@attrs.frozen
class Session:
    """One session of one participant, over one or more runs of the program."""

    id: int  # in the store
    code: str  # the participant's, as typed
    sub: str  # the participant's random word, which exports use
    number: int  # 1 for the participant's first session
    part: str
    row: int  # which order of the part's orders
    order: tuple[tuple[str, ...], ...]  # the conditions' names, one tuple per repeat
    origin: str  # one of ORIGINS
    status: str  # one of STATUSES
    plan: str  # text of the study file then
    started_utc: str  # ISO 8601, as all *_utc
    ended_utc: str = ""
    why: str = ""
    facts: Mapping[str, Any] = attrs.field(factory=dict, hash=False)  # versions, headset, GPU, seed
    consented: bool = True  # False while the plan's consent was not given, whatever the status


@attrs.frozen
class Answer:
    """A confirmed answer."""

    id: int
    session: int
    key: str  # of its step
    revision: int  # more than 1 where the question was repeated; the highest one counts
    phase: str
    trial: int
    scale: str
    item: str
    value: float | None  # None for "cannot say"
    seconds: float  # from the question to the answer
    by: str
    at_utc: str
    showing: int | None = None  # id of the Showing it is about
    text: str = ""  # of an answer in words


@attrs.frozen
class Showing:
    """A condition as it was really shown."""

    id: int
    session: int
    key: str  # of its step
    trial: int
    repeat: int
    condition: str
    presentation: int  # more than 1 where it had to be shown again
    complete: bool  # shown to its end
    settings: Mapping[str, Any] = attrs.field(factory=dict, hash=False)
    # Head trace, a file name in the store's `traces`, "" for none; may be missing if cut off.
    trace: str = ""
    actual: Mapping[str, Any] = attrs.field(factory=dict, hash=False)  # measured meanwhile: study/actual.py
    measured: Mapping[str, Any] = attrs.field(factory=dict, hash=False)  # by `study measure`, empty before
    started_utc: str = ""


@attrs.frozen
class Event:
    """An entry of the journal."""

    id: int
    session: int
    kind: str  # "shown", "answer", "pause", "continue", "break", "stop", "remark", "sick", "lost", "clock", ..
    key: str
    at_utc: str
    mono_ns: int  # monotonic clock of the machine, comparable within one run of the program
    data: Mapping[str, Any] = attrs.field(factory=dict, hash=False)


@attrs.frozen
class Contents:
    """All data of a study that are not withdrawn, in the order of their creation."""

    folder: Path  # of the store; traces lie in folder / "traces"
    name: str
    sessions: tuple[Session, ...]
    answers: tuple[Answer, ...]
    showings: tuple[Showing, ...]
    events: tuple[Event, ...]
    withdrawn: int = 0

    def session(self, id_: int) -> Session:
        """Return the session of that id. Errors: StopIteration."""
        return next(session for session in self.sessions if session.id == id_)


# A person took no part who refused the consent and did not agree later, in a resumed run, or who
# never agreed to the text that the session began with.
_AGREED = """SELECT 1 FROM event agreed
      WHERE agreed.session = s.id AND agreed.kind = 'finished' AND agreed.key = 'consent'"""
_REFUSED = f"""EXISTS (SELECT 1 FROM event refused WHERE refused.session = s.id AND refused.kind = 'refused')
    AND NOT EXISTS ({_AGREED})"""
_UNCONSENTED = f"""EXISTS (SELECT 1 FROM event asked WHERE asked.session = s.id AND asked.kind = 'begin'
      AND json_extract(asked.data, '$.consent_version') IS NOT NULL) AND NOT EXISTS ({_AGREED})"""
_STATUS = f"""CASE WHEN s.status = 'stopped' AND {_REFUSED} THEN 'declined'
    WHEN s.status = 'stopped' AND {_UNCONSENTED} THEN 'unconsented' ELSE s.status END"""
_SESSION = f"""SELECT s.id, p.code, p.sub, s.number, s.part, s.order_row, s.order_names, p.origin, {_STATUS}, plan.text,
  s.started_utc, s.ended_utc, s.why, s.facts, NOT (({_REFUSED}) OR ({_UNCONSENTED}))
  FROM session s JOIN participant p ON p.id = s.participant JOIN plan ON plan.id = s.plan"""
# Words are in the journal alone, so that stores from before there were any can be read.
_ANSWER = """SELECT id, session, key, revision, phase, trial, scale, item, value, seconds, answered_by, at_utc, showing,
  coalesce((SELECT json_extract(e.data, '$.text') FROM event e WHERE e.session = answer.session AND e.kind = 'answer'
    AND e.key = answer.key AND json_extract(e.data, '$.revision') = answer.revision), '')
  FROM answer"""
_SHOWING = """SELECT id, session, key, trial, repeat, condition, presentation, complete, settings, trace, actual,
  measured, started_utc FROM showing"""
_EVENT = "SELECT id, session, kind, key, at_utc, mono_ns, data FROM event"


def _session_of(row: tuple[Any, ...]) -> Session:
    fields = list(row)
    fields[6] = tuple(tuple(repeat) for repeat in from_json(fields[6]))
    fields[-2:] = from_json(fields[-2]), bool(fields[-1])
    return Session(*fields)


def _showing_of(row: tuple[Any, ...]) -> Showing:
    *values, complete, settings, trace, actual, measured, started = row
    fields = [*values, bool(complete), dict_in(settings), trace, dict_in(actual), dict_in(measured), started]
    return Showing(*fields)


def passed_s(db: sqlite3.Connection, id_: int) -> tuple[float, bool]:
    """Return the time as Store.passed_s, and whether that between all runs counts."""
    query = "SELECT kind, at_utc, mono_ns FROM event WHERE session = ? AND kind <> 'clock' ORDER BY id"
    passed, counts_all = 0.0, True
    for (_, before, before_ns), (kind, now, now_ns) in itertools.pairwise(db.execute(query, (id_,)).fetchall()):
        if kind == "resume":
            gap_s = (datetime.fromisoformat(now) - datetime.fromisoformat(before)).total_seconds()
            counts_all = counts_all and gap_s >= 0
        else:
            gap_s = (now_ns - before_ns) * 1e-9
        passed += max(gap_s, 0.0)  # an entry that 0.2 had rescued has no monotonic time
    return passed, counts_all


def _one(db: sqlite3.Connection, query: str, id_: int) -> tuple[Any, ...]:
    row: tuple[Any, ...] | None = db.execute(f"{query} = ?", (id_,)).fetchone()
    if row is None:
        raise KeyError(id_)
    return row


def session(db: sqlite3.Connection, id_: int) -> Session:
    """Return the session of that id. Errors: KeyError."""
    return _session_of(_one(db, f"{_SESSION} WHERE s.id", id_))


def sessions_of(db: sqlite3.Connection, code: str) -> list[Session]:
    """Return all sessions of a participant, the first one first."""
    rows = db.execute(f"{_SESSION} WHERE p.code = ? AND NOT p.withdrawing ORDER BY s.number", (code,))
    return [_session_of(row) for row in rows]


def answer(db: sqlite3.Connection, id_: int) -> Answer:
    """Return the answer of that id. Errors: KeyError."""
    return Answer(*_one(db, f"{_ANSWER} WHERE id", id_))


def showing(db: sqlite3.Connection, id_: int) -> Showing:
    """Return the showing of that id. Errors: KeyError."""
    return _showing_of(_one(db, f"{_SHOWING} WHERE id", id_))


def last_answers(db: sqlite3.Connection, session_id: int) -> tuple[Answer, ...]:
    """Return the last answer to each question of a session, in the order of the questions."""
    rows = db.execute(f"{_ANSWER} WHERE session = ? ORDER BY id", (session_id,))
    return tuple({one.key: one for one in (Answer(*row) for row in rows)}.values())


def contents(db: sqlite3.Connection, folder: Path, pilot: bool) -> Contents:
    """Return all data of one moment: of people and simulated participants, or of pilots."""
    db.execute("BEGIN")  # one state for all queries, even while another process writes
    try:
        where = f"NOT p.withdrawing AND p.origin {'=' if pilot else '<>'} '{PILOT}'"
        sessions = tuple(_session_of(row) for row in db.execute(f"{_SESSION} WHERE {where} ORDER BY s.id"))
        ids = f"SELECT s.id FROM session s JOIN participant p ON p.id = s.participant WHERE {where}"
        of = f"WHERE session IN ({ids}) ORDER BY id"
        answers = tuple(Answer(*row) for row in db.execute(f"{_ANSWER} {of}"))
        showings = tuple(_showing_of(row) for row in db.execute(f"{_SHOWING} {of}"))
        events = tuple(Event(*[*row[:-1], dict_in(row[-1])]) for row in db.execute(f"{_EVENT} {of}"))
        name = study_name(db)
        gone = "SELECT (SELECT count(*) FROM withdrawn) + (SELECT count(*) FROM participant WHERE withdrawing)"
        withdrawn = db.execute(gone).fetchone()[0]
        return Contents(folder, name, sessions, answers, showings, events, withdrawn)
    finally:
        db.execute("ROLLBACK")  # nothing was written


def study_name(db: sqlite3.Connection) -> str:
    """Return the name of the study."""
    return str(db.execute("SELECT name FROM study").fetchone()[0])
