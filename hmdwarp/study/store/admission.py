"""Decides who may begin or resume a session, and which order it gets; draws participants' codes.

All functions run on an open transaction.
"""

from __future__ import annotations

import json
import os
import re
import secrets
import sqlite3
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from ...errors import InputError
from ..design import ONE, Condition, Design, Order, allot, rows_for
from ..scales import Item, Scale
from . import records
from .records import COMPLETE, INTERRUPTED, PERSON, PILOT, RUNNING, SIMULATED, Session, from_json, to_json


def plan_signature(design: Design, part: str) -> dict[str, Any]:
    """Return the signature as JSON data.

    Titles, comments, breaks, the consent's text, families and other parts are not in it: they may
    change. So may the folder of the file, together with the files beside it.
    """
    folder = f"{Path(design.path).parent.absolute()}{os.sep}"
    rule = design.sickness
    return {
        "conditions": [_condition(condition, folder) for condition in design.part(part).conditions],
        "seconds": ["until done", float(design.seconds)] if design.until_done else float(design.seconds),
        "repeats": design.repeats,
        "order": design.order,
        "seed": design.seed,
        "scales": [_scale(scale) for scale in design.scales],
        "practice": None
        if design.practice is None
        else [_condition(design.practice, folder), float(design.practice_seconds)],
        "sickness": (
            None
            if rule is None
            else {"scale": _scale(rule.scale), "every": rule.every, "stop_at": rule.stop_at, "rise": rule.rise}
        ),
        "before": [_scale(scale) for scale in design.before],
        "after": [_scale(scale) for scale in design.after],
        **_shows(design),
    }


def _shows(design: Design) -> dict[str, Any]:
    """Return what a trial shows; nothing for one condition, as older sessions have it."""
    return {} if design.shows == ONE else {"shows": design.shows}


def _condition(condition: Condition, folder: str) -> dict[str, Any]:
    settings = {
        name: value.removeprefix(folder) if isinstance(value, str) else value
        for name, value in sorted(condition.settings.items())
    }
    return {"name": condition.name, "settings": settings, "reference": condition.reference}


def _scale(scale: Scale) -> dict[str, Any]:
    """Return the questions in their words, and the possible answers."""
    return {
        "name": scale.name,
        "asked": [scale.prompt, *([item.key, item.text, *_own(item)] for item in scale.items)],
        "range": [scale.least, scale.most, scale.step],
        "anchors": {f"{value:g}": words for value, words in sorted(scale.anchors.items())},
        "low_is_good": scale.low_is_good,
    }


def _own(item: Item) -> list[Any]:
    """Return the answers of a question that has its own, or its own words for some."""
    if item.anchors:
        return [{f"{value:g}": words for value, words in item.anchors.items()}]
    return [item.answer, list(item.choices), item.least, item.most, item.step] if item.answer else []


def signature_changes(before: Mapping[str, Any], now: Mapping[str, Any]) -> list[str]:
    """Describe what differs between two signatures, both decoded from JSON."""
    changed = [key for key in {**before, **now} if before.get(key) != now.get(key)]
    return [_conditions(before[key], now[key]) if key == "conditions" else key for key in changed]


def _conditions(before: list[dict[str, Any]], now: list[dict[str, Any]]) -> str:
    was, is_ = ({condition["name"]: condition for condition in side} for side in (before, now))
    words = [f"'{name}' is new" for name in is_ if name not in was] + [
        f"'{name}' is gone" for name in was if name not in is_
    ]
    words += [f"'{name}' changed" for name in is_ if name in was and was[name] != is_[name]]
    return f"conditions ({', '.join(words) or 'in another order'})"


HOLDING = (RUNNING, INTERRUPTED, COMPLETE)  # other sessions free their order for another participant
NEW = "new"
_CODE = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_-]{0,31}")
# Without 0 and O, 1, I and L, 2 and Z, 5 and S, 9 and g, which are easily confused.
_CLEAR = "ABCDEFGHJKMNPQRTUVWXY34678"
_SUB = "abcdefghijklmnopqrstuvwxyz0123456789"  # BIDS labels take only letters and digits


def check_code(code: str) -> None:
    """Raise InputError for an invalid code."""
    if not _CODE.fullmatch(code):
        raise InputError(
            f"--participant {code!r}: expected a code of 1 to 32 letters a-z, digits, - and _, as P07, not - first; it "
            "must not be a name, nor identify the person ('new' draws one)"
        )


def _draw(signs: str, length: int, taken: Callable[[str], bool]) -> str:
    while True:
        word = "".join(secrets.choice(signs) for _ in range(length))
        if not taken(word):
            return word


def participant_for(db: sqlite3.Connection, code: str, part: str, origin: str, new_session: bool) -> int:
    """Return the participant's row, inserted for a new one. Errors: InputError, as Store.begin."""
    other = {PERSON: SIMULATED, SIMULATED: PERSON}.get(origin)
    if other and db.execute("SELECT 1 FROM participant WHERE origin = ?", (other,)).fetchone():
        raise InputError(
            f"this store holds {other} participants; a {origin} one must not be mixed with them: use another "
            "folder (--store), or --pilot"
        )
    if code.lower() == NEW:
        if new_session:
            raise _new_again()
        return _new_participant(db, _draw(_CLEAR, 5, lambda drawn: is_taken(db, drawn)), origin)
    check_code(code)
    if is_withdrawn(db, code):
        raise InputError(f"participant {code} has withdrawn, and codes are not reused: take another ('new' draws one)")
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
    return int(id_)


def check_first(code: str, new_session: bool) -> None:
    """Check as participant_for does, before there is a store."""
    if code.lower() == NEW:
        if new_session:
            raise _new_again()
        return
    check_code(code)
    if new_session:
        raise _unknown(code)


def _new_again() -> InputError:
    return InputError(
        "--participant new draws a code for a new participant: --new-session needs the code of a known one"
    )


def _unknown(code: str) -> InputError:
    return InputError(f"participant {code} is not known here: leave out --new-session, or check the code")


def is_withdrawn(db: sqlite3.Connection, code: str) -> bool:
    """Return whether the data of that code were erased, or are being erased."""
    query = (
        "SELECT 1 FROM withdrawn WHERE code = :code UNION SELECT 1 FROM participant WHERE code = :code AND withdrawing"
    )
    return db.execute(query, {"code": code}).fetchone() is not None


def is_taken(db: sqlite3.Connection, code: str) -> bool:
    """Return whether the code is or was in use, or is a random word."""
    query = """SELECT 1 FROM participant WHERE code = :code OR sub = lower(:code)
      UNION SELECT 1 FROM withdrawn WHERE code = :code"""
    return db.execute(query, {"code": code}).fetchone() is not None


def _already(db: sqlite3.Connection, code: str, part: str) -> str:
    sessions = records.sessions_of(db, code)
    resumable = any(session.part == part and session.status == INTERRUPTED for session in sessions)
    resume = "--resume resumes it, " if resumable else ""
    known = f"participant {code} is known here ({_listed(sessions)})"
    return f"{known}: {resume}--new-session begins another one; a different participant needs a different code"


def _listed(sessions: Sequence[Session]) -> str:
    return ", ".join(f"session {session.number} of part '{session.part}' {session.status}" for session in sessions)


def _new_participant(db: sqlite3.Connection, code: str, origin: str) -> int:
    sub = _draw(_SUB, 12, lambda drawn: is_taken(db, drawn))
    return insert(db, "participant", code=code, sub=sub, origin=origin)


def allotted(db: sqlite3.Connection, design: Design, part: str, origin: str) -> tuple[int, Order]:
    """Return the next order, one that fewest sessions of this origin hold."""
    rows = rows_for(design, part)
    query = f"""SELECT s.order_row, count(*) FROM session s JOIN participant p ON p.id = s.participant
      WHERE s.part = ? AND p.origin = ? AND s.status IN ({", ".join("?" * len(HOLDING))}) AND NOT p.withdrawing
      GROUP BY s.order_row"""
    counts = dict(db.execute(query, (part, origin, *HOLDING)).fetchall())
    row = allot([counts.get(row, 0) for row in range(len(rows))], design.seed)
    return row, rows[row]


def check_plan(db: sqlite3.Connection, design: Design, part: str, origin: str) -> bool:
    """Return whether the plan's text differs from the last session's of this part.

    Errors: InputError where sessions of this part ran with a plan of another signature: ratings
    would not be comparable, nor orders balanced. A changed plan is a study of its own. Pilots may
    change anything.
    """
    if origin == PILOT:
        return False
    now = from_json(to_json(plan_signature(design, part)))
    rows = rows_for(design, part)
    found = db.execute(
        """SELECT DISTINCT plan.meaning, s.order_row, s.order_names FROM session s JOIN plan ON plan.id = s.plan
          JOIN participant p ON p.id = s.participant WHERE s.part = ? AND p.origin = ?""",
        (part, origin),
    ).fetchall()
    for was, row, names in found:
        different = signature_changes(from_json(was), now)
        if not different and (row >= len(rows) or [list(names_) for names_ in rows[row]] != from_json(names)):
            different = ["the orders"]
        if different:
            raise InputError(
                f"{design.path or design.name}: sessions of part '{part}' ran with another plan "
                f"({', '.join(different)}): "
                "ratings before and after would not be comparable; undo the change, or make it a study of "
                "its own (name, --store)"
            )
    latest = db.execute(
        """SELECT plan.text FROM session s JOIN plan ON plan.id = s.plan JOIN participant p ON p.id = s.participant
          WHERE s.part = ? AND p.origin = ? ORDER BY s.id DESC LIMIT 1""",
        (part, origin),
    ).fetchone()
    return latest is not None and latest[0] != design.text


def check_same(db: sqlite3.Connection, design: Design, session: Session) -> None:
    """Raise InputError where a session's plan, read again, has another signature.

    The store keeps its text, but not custom scales that it names. Pilots may change anything.
    """
    if session.origin == PILOT:
        return
    was = db.execute(
        "SELECT plan.meaning FROM session s JOIN plan ON plan.id = s.plan WHERE s.id = ?", (session.id,)
    ).fetchone()[0]
    different = signature_changes(from_json(was), from_json(to_json(plan_signature(design, session.part))))
    if different:
        raise InputError(
            f"{design.path or design.name}: files that it names changed since the session began "
            f"({', '.join(different)}): undo that"
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
    """Insert a session with the next order; return its id."""
    row, order = allotted(db, design, part, origin)
    plan = (design.text, to_json(plan_signature(design, part)))
    db.execute("INSERT OR IGNORE INTO plan (text, meaning) VALUES (?, ?)", plan)
    plan_id = db.execute("SELECT id FROM plan WHERE text = ? AND meaning = ?", plan).fetchone()[0]
    number = db.execute(
        "SELECT coalesce(max(number), 0) + 1 FROM session WHERE participant = ?", (participant,)
    ).fetchone()[0]
    names = json.dumps(order, ensure_ascii=False, separators=(",", ":"))
    return insert(
        db, "session", participant=participant, number=number, part=part, order_row=row, order_names=names,
        plan=plan_id, status=RUNNING, started_utc=started_utc, facts=to_json(facts),
    )  # fmt: skip


def insert(db: sqlite3.Connection, table: str, **values: Any) -> int:
    """Insert a row and return its id."""
    statement = f"INSERT INTO {table} ({', '.join(values)}) VALUES ({', '.join('?' * len(values))})"
    id_ = db.execute(statement, tuple(values.values())).lastrowid
    assert id_ is not None
    return id_


def to_resume(db: sqlite3.Connection, code: str, part: str | None) -> Session:
    """Return the interrupted session.

    Errors: InputError where there is none, or several parts have one.
    """
    check_code(code)
    if is_withdrawn(db, code):
        raise InputError(f"participant {code} has withdrawn: there is nothing to resume")
    sessions = records.sessions_of(db, code)
    if not sessions:
        raise InputError(f"participant {code} is not known here: leave out --resume, or check the code")
    open_ = [session for session in sessions if session.status == INTERRUPTED and part in (None, session.part)]
    if not open_:
        raise InputError(
            f"participant {code} has no interrupted session to resume ({_listed(sessions)}): --new-session begins "
            "another"
        )
    parts = sorted({session.part for session in open_})
    if len(parts) > 1:
        raise InputError(
            f"participant {code} has interrupted sessions of several parts ({', '.join(parts)}): choose one with "
            "--part NAME"
        )
    return open_[-1]


def chosen_part(design: Design, part: str | None) -> str:
    """Return the part, by default the only one.

    Errors: InputError for a part that the plan lacks, or where one of several must be named.
    """
    names = [part.name for part in design.parts]
    if part is None and len(names) == 1:
        return names[0]
    if part is None or part not in names:
        found = f"--part {part} is not in" if part else "--part is missing for"
        raise InputError(f"{found} {design.path or design.name}: it has {', '.join(names)}")
    return part
