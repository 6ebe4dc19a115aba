"""Queries of the store: rows of the tables as records."""

from __future__ import annotations

import itertools
import sqlite3
from datetime import datetime
from pathlib import Path
from typing import Any

from .records import PILOT, Answer, Contents, Event, Session, Showing, dict_in, from_json

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


def _event_of(row: tuple[Any, ...]) -> Event:
    fields: list[Any] = [*row[:-1], dict_in(row[-1])]
    return Event(*fields)


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


def session(db: sqlite3.Connection, id_: int) -> Session:
    """Return the session of that id. Errors: KeyError."""
    row = db.execute(f"{_SESSION} WHERE s.id = ?", (id_,)).fetchone()
    if row is None:
        raise KeyError(id_)
    return _session_of(row)


def sessions_of(db: sqlite3.Connection, code: str) -> list[Session]:
    """Return all sessions of a participant, the first one first."""
    rows = db.execute(f"{_SESSION} WHERE p.code = ? AND NOT p.withdrawing ORDER BY s.number", (code,))
    return [_session_of(row) for row in rows]


def answer(db: sqlite3.Connection, id_: int) -> Answer:
    """Return the answer of that id."""
    return Answer(*db.execute(f"{_ANSWER} WHERE id = ?", (id_,)).fetchone())


def showing(db: sqlite3.Connection, id_: int) -> Showing:
    """Return the showing of that id. Errors: KeyError."""
    row = db.execute(f"{_SHOWING} WHERE id = ?", (id_,)).fetchone()
    if row is None:
        raise KeyError(id_)
    return _showing_of(row)


def last_answers(db: sqlite3.Connection, session_id: int) -> tuple[Answer, ...]:
    """Return the last answer to each question of a session, in the order of the questions."""
    rows = db.execute(f"{_ANSWER} WHERE session = ? ORDER BY id", (session_id,))
    latest: dict[str, Answer] = {}
    for row in rows:
        one = Answer(*row)
        latest[one.key] = one  # a revision comes after what it revises, and takes its place in the order
    return tuple(latest.values())


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
        events = tuple(_event_of(row) for row in db.execute(f"{_EVENT} {of}"))
        name = study_name(db)
        gone = "SELECT (SELECT count(*) FROM withdrawn) + (SELECT count(*) FROM participant WHERE withdrawing)"
        withdrawn = db.execute(gone).fetchone()[0]
        return Contents(folder, name, sessions, answers, showings, events, withdrawn)
    finally:
        db.execute("ROLLBACK")  # nothing was written


def study_name(db: sqlite3.Connection) -> str:
    """Return the name of the study."""
    return str(db.execute("SELECT name FROM study").fetchone()[0])
