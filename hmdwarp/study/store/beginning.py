"""Who may begin a session, with which order; and which session is gone on with. All on an open transaction."""

from __future__ import annotations

import sqlite3
from collections.abc import Mapping, Sequence
from typing import Any

from ...errors import InputError
from ..design import Design, Order, allot, rows_for
from . import reading
from ._json import from_json, to_json
from .codes import NEW, check_code, draw_code, draw_sub
from .meaning import differences, meaning
from .nouns import COMPLETE, INTERRUPTED, PERSON, PILOT, RUNNING, SIMULATED, Session

HOLDING = (RUNNING, INTERRUPTED, COMPLETE)  # whoever stopped, was sick or withdrew leaves the order to another


def participant_for(db: sqlite3.Connection, code: str, part: str, origin: str, new_session: bool) -> int:
    """The participant's row, made where it is a new one. Errors: InputError, as Store.begin."""
    _check_origin(db, origin)
    if code.lower() == NEW:
        if new_session:
            raise _new_again()
        return _new_participant(db, draw_code(lambda drawn: is_taken(db, drawn)), origin)
    check_code(code)
    if is_withdrawn(db, code):
        raise InputError(f"participant {code} has withdrawn: a code is not used again; take another ('new' draws one)")
    known = db.execute("SELECT id, code, origin FROM participant WHERE code = ?", (code,)).fetchone()
    if known is None:
        if new_session:
            raise _unknown(code)
        return _new_participant(db, code, origin)
    id_, code, was = known
    if was != origin:
        raise InputError(f"participant {code} is a {was} here, not a {origin}: take another code")
    if not new_session:
        raise InputError(_already(db, code, part))
    return id_


def check_first(code: str, new_session: bool) -> None:
    """As participant_for, where there is no store yet."""
    if code.lower() == NEW:
        if new_session:
            raise _new_again()
        return
    check_code(code)
    if new_session:
        raise _unknown(code)


def _new_again() -> InputError:
    return InputError("--participant new draws a code for somebody new: --new-session needs the code of somebody known")


def _unknown(code: str) -> InputError:
    return InputError(
        f"participant {code} is not known here: leave --new-session away, or see whether the code is right"
    )


def _check_origin(db: sqlite3.Connection, origin: str) -> None:
    """Made-up ratings must not get among people's."""
    other = {PERSON: SIMULATED, SIMULATED: PERSON}.get(origin)
    if other and db.execute("SELECT 1 FROM participant WHERE origin = ?", (other,)).fetchone():
        raise InputError(
            f"this store holds {other} participants, and a {origin} one must not get among them: use another folder (--store), or --pilot"
        )


def is_withdrawn(db: sqlite3.Connection, code: str) -> bool:
    """Whether that code's data were erased, or are being so."""
    query = (
        "SELECT 1 FROM withdrawn WHERE code = :code UNION SELECT 1 FROM participant WHERE code = :code AND withdrawing"
    )
    return db.execute(query, {"code": code}).fetchone() is not None


def is_taken(db: sqlite3.Connection, code: str) -> bool:
    """Whether somebody has that code or had it, or it is a sub."""
    query = """SELECT 1 FROM participant WHERE code = :code OR sub = lower(:code) UNION SELECT 1 FROM withdrawn WHERE code = :code"""
    return db.execute(query, {"code": code}).fetchone() is not None


def _already(db: sqlite3.Connection, code: str, part: str) -> str:
    sessions = reading.sessions_of(db, code)
    told = ", ".join(f"session {one.number} of part '{one.part}' {one.status}" for one in sessions)
    going_on = any(one.part == part and one.status == INTERRUPTED for one in sessions)
    resume = "--resume goes on with it, " if going_on else ""
    return f"participant {code} is known here ({told}): {resume}--new-session begins another, somebody else needs another code"


def _new_participant(db: sqlite3.Connection, code: str, origin: str) -> int:
    sub = draw_sub(lambda drawn: is_taken(db, drawn))
    return db.execute("INSERT INTO participant (code, sub, origin) VALUES (?, ?, ?)", (code, sub, origin)).lastrowid


def allotted(db: sqlite3.Connection, design: Design, part: str, origin: str) -> tuple[int, Order]:
    """Which order is next: one that fewest hold. Sessions of another origin do not count."""
    rows = rows_for(design, part)
    query = f"""SELECT s.order_row, count(*) FROM session s JOIN participant p ON p.id = s.participant
      WHERE s.part = ? AND p.origin = ? AND s.status IN ({", ".join("?" * len(HOLDING))}) AND NOT p.withdrawing GROUP BY s.order_row"""
    counts = dict(db.execute(query, (part, origin, *HOLDING)).fetchall())
    row = allot([counts.get(row, 0) for row in range(len(rows))], design.seed)
    return row, rows[row]


def check_plan(db: sqlite3.Connection, design: Design, part: str, origin: str) -> bool:
    """Whether the text of the plan is another than the last session's of this part. Pilots may change what they like.

    Errors: InputError where sessions of this part were made with a plan that means something else: ratings before and after could not be
    compared, and the balance of the orders would be a mixture of two. A changed plan is a study of its own.
    """
    if origin == PILOT:
        return False
    now = from_json(to_json(meaning(design, part)))
    rows = rows_for(design, part)
    found = db.execute(
        """SELECT DISTINCT plan.meaning, s.order_row, s.order_names FROM session s JOIN plan ON plan.id = s.plan
          JOIN participant p ON p.id = s.participant WHERE s.part = ? AND p.origin = ?""",
        (part, origin),
    ).fetchall()
    for was, row, names in found:
        different = differences(from_json(was), now)
        if not different and (row >= len(rows) or [list(one) for one in rows[row]] != from_json(names)):
            different = ["the orders"]
        if different:
            raise InputError(
                f"{design.path or design.name}: sessions of part '{part}' were made with another plan ({', '.join(different)}): "
                "what was rated before and after could not be compared; put it back, or make it a study of its own (name, --store)"
            )
    latest = db.execute(
        """SELECT plan.text FROM session s JOIN plan ON plan.id = s.plan JOIN participant p ON p.id = s.participant
          WHERE s.part = ? AND p.origin = ? ORDER BY s.id DESC LIMIT 1""",
        (part, origin),
    ).fetchone()
    return latest is not None and latest[0] != design.text


def check_same(db: sqlite3.Connection, design: Design, session: Session) -> None:
    """Errors: InputError where a session's plan, read once more, means something else: the text is kept, but not the scales of one's own
    that it names. Pilots may change what they like."""
    if session.origin == PILOT:
        return
    was = db.execute(
        "SELECT plan.meaning FROM session s JOIN plan ON plan.id = s.plan WHERE s.id = ?", (session.id,)
    ).fetchone()[0]
    different = differences(from_json(was), from_json(to_json(meaning(design, session.part))))
    if different:
        raise InputError(
            f"{design.path or design.name}: what it names has changed since the session began ({', '.join(different)}): put it back"
        )


def new_session(
    db: sqlite3.Connection,
    design: Design,
    part: str,
    participant: int,
    origin: str,
    facts: Mapping[str, Any],
    started_utc: str,
) -> int:
    """The id of a session with the order whose turn it is."""
    row, order = allotted(db, design, part, origin)
    plan = (design.text, to_json(meaning(design, part)))
    db.execute("INSERT OR IGNORE INTO plan (text, meaning) VALUES (?, ?)", plan)
    plan_id = db.execute("SELECT id FROM plan WHERE text = ? AND meaning = ?", plan).fetchone()[0]
    number = db.execute(
        "SELECT coalesce(max(number), 0) + 1 FROM session WHERE participant = ?", (participant,)
    ).fetchone()[0]
    names = to_json({"order": order})[len('{"order":') : -1]
    return db.execute(
        """INSERT INTO session (participant, number, part, order_row, order_names, plan, status, started_utc, facts)
          VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)""",
        (participant, number, part, row, names, plan_id, RUNNING, started_utc, to_json(facts)),
    ).lastrowid


def to_resume(db: sqlite3.Connection, code: str, part: str | None) -> Session:
    """The interrupted session. Errors: InputError where there is none, or more than one that may be meant."""
    check_code(code)
    if is_withdrawn(db, code):
        raise InputError(f"participant {code} has withdrawn: there is nothing to go on with")
    sessions = reading.sessions_of(db, code)
    if not sessions:
        raise InputError(f"participant {code} is not known here: leave --resume away, or see whether the code is right")
    open_ = [one for one in sessions if one.status == INTERRUPTED and part in (None, one.part)]
    if not open_:
        told = ", ".join(f"session {one.number} of part '{one.part}' {one.status}" for one in sessions)
        raise InputError(
            f"participant {code} has no interrupted session to go on with ({told}): --new-session begins another"
        )
    parts = sorted({one.part for one in open_})
    if len(parts) > 1:
        raise InputError(
            f"participant {code} has interrupted sessions of several parts ({', '.join(parts)}): say which one, --part NAME"
        )
    return open_[-1]


def the_part(design: Design, part: str | None) -> str:
    """Errors: InputError for a part that the plan has not, or where one of several must be named."""
    names: Sequence[str] = [one.name for one in design.parts]
    if part is None and len(names) == 1:
        return names[0]
    if part not in names:
        found = f"--part {part} is not in" if part else "--part is missing for"
        raise InputError(f"{found} {design.path or design.name}: it has {', '.join(names)}")
    return part
