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

from ...base import InputError
from ..design import ONE, Condition, Design, allot, rows_for
from ..scales import Scale
from . import records
from .records import COMPLETE, INTERRUPTED, PERSON, PILOT, RUNNING, SIMULATED, Session, from_json, to_json


def plan_signature(design: Design, part: str) -> dict[str, Any]:
    """Return, as JSON data, what may not change within a study."""
    folder = f"{Path(design.path).parent.absolute()}{os.sep}"
    practice, rule = design.practice, design.sickness
    stops = rule and {"every": rule.every, "stop_at": rule.stop_at, "rise": rule.rise}
    return {
        "conditions": [_condition(condition, folder) for condition in design.part(part).conditions],
        "seconds": ["until done", float(design.seconds)] if design.until_done else float(design.seconds),
        "repeats": design.repeats,
        "order": design.order,
        "seed": design.seed,
        "scales": [_scale(scale) for scale in design.scales],
        "practice": practice and [_condition(practice, folder), float(design.practice_seconds)],
        "sickness": rule and {"scale": _scale(rule.scale), **(stops or {})},
        "before": [_scale(scale) for scale in design.before],
        "after": [_scale(scale) for scale in design.after],
        **({} if design.shows == ONE else {"shows": design.shows}),  # older sessions show one
    }


def _condition(condition: Condition, folder: str) -> dict[str, Any]:
    settings = {
        name: value.removeprefix(folder) if isinstance(value, str) else value
        for name, value in sorted(condition.settings.items())
    }
    return {"name": condition.name, "settings": settings, "reference": condition.reference}


def _scale(scale: Scale) -> dict[str, Any]:
    """Return the questions in their words, and the possible answers; with those of their own."""
    asked: list[Any] = [scale.prompt]
    for item in scale.items:
        own: list[Any] = [item.answer, list(item.choices), item.least, item.most, item.step] if item.answer else []
        own = [{f"{value:g}": words for value, words in item.anchors.items()}] if item.anchors else own
        asked.append([item.key, item.text, *own])
    return {
        "name": scale.name,
        "asked": asked,
        "range": [scale.least, scale.most, scale.step],
        "anchors": {f"{value:g}": words for value, words in sorted(scale.anchors.items())},
        "low_is_good": scale.low_is_good,
    }


def signature_changes(before: Mapping[str, Any], now: Mapping[str, Any]) -> list[str]:
    """Describe what differs between two signatures, both decoded from JSON."""
    changed = [key for key in {**before, **now} if before.get(key) != now.get(key)]
    if "conditions" in changed:
        was, is_ = ({condition["name"]: condition for condition in of["conditions"]} for of in (before, now))
        words = [f"'{name}' is new" for name in is_ if name not in was]
        words += [f"'{name}' is gone" for name in was if name not in is_]
        words += [f"'{name}' changed" for name in is_ if name in was and was[name] != is_[name]]
        described = f"conditions ({', '.join(words) or 'in another order'})"
        changed[changed.index("conditions")] = described
    return changed


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
    is_new = code.lower() == NEW
    if not is_new:
        check_code(code)
    known = db.execute("SELECT id, code, origin FROM participant WHERE code = ?", (code,)).fetchone()
    if not is_new and _is_withdrawn(db, code):
        raise InputError(f"participant {code} has withdrawn, and codes are not reused: take another ('new' draws one)")
    if is_new or known is None:
        check_first(code, new_session)
        code = _draw(_CLEAR, 5, lambda drawn: _is_taken(db, drawn)) if is_new else code
        sub = _draw(_SUB, 12, lambda drawn: _is_taken(db, drawn))
        return insert(db, "participant", code=code, sub=sub, origin=origin)
    id_, code, was = known
    if was != origin:
        raise InputError(f"participant {code} is a {was} here, not a {origin}: take another code")
    if not new_session:
        sessions = records.sessions_of(db, code)
        resumable = any(session.part == part and session.status == INTERRUPTED for session in sessions)
        how = f"{'--resume resumes it, ' if resumable else ''}--new-session begins another one"
        raise InputError(
            f"participant {code} is known here ({_listed(sessions)}): {how}; a different participant needs a different "
            "code"
        )
    return int(id_)


def check_first(code: str, new_session: bool) -> None:
    """Check the code of a participant who is not known, also before there is a store."""
    is_new = code.lower() == NEW
    if not is_new:
        check_code(code)
    if new_session and is_new:
        raise InputError(
            "--participant new draws a code for a new participant: --new-session needs the code of a known one"
        )
    if new_session:
        raise InputError(f"participant {code} is not known here: leave out --new-session, or check the code")


def _is_withdrawn(db: sqlite3.Connection, code: str) -> bool:
    """Return whether the data of that code were erased, or are being erased."""
    query = """SELECT 1 FROM withdrawn WHERE code = :code
      UNION SELECT 1 FROM participant WHERE code = :code AND withdrawing"""
    return db.execute(query, {"code": code}).fetchone() is not None


def _is_taken(db: sqlite3.Connection, code: str) -> bool:
    """Return whether the code is or was in use, or is a random word."""
    query = """SELECT 1 FROM participant WHERE code = :code OR sub = lower(:code)
      UNION SELECT 1 FROM withdrawn WHERE code = :code"""
    return db.execute(query, {"code": code}).fetchone() is not None


def _listed(sessions: Sequence[Session]) -> str:
    return ", ".join(f"session {session.number} of part '{session.part}' {session.status}" for session in sessions)


def check_plan(db: sqlite3.Connection, design: Design, part: str, origin: str) -> bool:
    """Return whether the plan's text differs from the last session's of this part.

    Errors: InputError where sessions of people ran with a plan of another signature, as ratings
    would not be comparable, nor orders balanced.
    """
    if origin == PILOT:
        return False
    now, rows = from_json(to_json(plan_signature(design, part))), rows_for(design, part)
    found = db.execute(
        """SELECT plan.meaning, s.order_row, s.order_names, plan.text FROM session s JOIN plan ON plan.id = s.plan
          JOIN participant p ON p.id = s.participant WHERE s.part = ? AND p.origin = ? ORDER BY s.id""",
        (part, origin),
    ).fetchall()
    for was, row, names, _ in found:
        different = signature_changes(from_json(was), now)
        if not different and (row >= len(rows) or [list(names_) for names_ in rows[row]] != from_json(names)):
            different = ["the orders"]
        if different:
            raise InputError(
                f"{design.path or design.name}: sessions of part '{part}' ran with another plan "
                f"({', '.join(different)}): ratings before and after would not be comparable; undo the change, or make "
                "it a study of its own (name, --store)"
            )
    return bool(found) and found[-1][-1] != design.text


def check_same(db: sqlite3.Connection, design: Design, session: Session) -> None:
    """Raise InputError where a session's plan, read again with its own scales, differs."""
    if session.origin == PILOT:
        return
    query = "SELECT plan.meaning FROM session s JOIN plan ON plan.id = s.plan WHERE s.id = ?"
    (was,) = db.execute(query, (session.id,)).fetchone()
    different = signature_changes(from_json(was), from_json(to_json(plan_signature(design, session.part))))
    if different:
        found = f"files that it names changed since the session began ({', '.join(different)})"
        raise InputError(f"{design.path or design.name}: {found}: undo that")


def new_session(
    db: sqlite3.Connection,
    design: Design,
    part: str,
    participant: int,
    origin: str,
    facts: Mapping[str, Any],
    started_utc: str,
) -> int:
    """Insert a session with an order that fewest sessions of this origin hold; return its id."""
    rows = rows_for(design, part)
    query = f"""SELECT s.order_row, count(*) FROM session s JOIN participant p ON p.id = s.participant
      WHERE s.part = ? AND p.origin = ? AND s.status IN ({", ".join("?" * len(HOLDING))}) AND NOT p.withdrawing
      GROUP BY s.order_row"""
    counts = dict(db.execute(query, (part, origin, *HOLDING)).fetchall())
    row = allot([counts.get(row, 0) for row in range(len(rows))], design.seed)
    plan = (design.text, to_json(plan_signature(design, part)))
    db.execute("INSERT OR IGNORE INTO plan (text, meaning) VALUES (?, ?)", plan)
    (plan_id,) = db.execute("SELECT id FROM plan WHERE text = ? AND meaning = ?", plan).fetchone()
    query = "SELECT coalesce(max(number), 0) + 1 FROM session WHERE participant = ?"
    (number,) = db.execute(query, (participant,)).fetchone()
    names = json.dumps(rows[row], ensure_ascii=False, separators=(",", ":"))
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
    """Return the interrupted session. Errors: InputError for none, or several."""
    check_code(code)
    if _is_withdrawn(db, code):
        raise InputError(f"participant {code} has withdrawn: there is nothing to resume")
    sessions = records.sessions_of(db, code)
    if not sessions:
        raise InputError(f"participant {code} is not known here: leave out --resume, or check the code")
    open_ = [session for session in sessions if session.status == INTERRUPTED and part in (None, session.part)]
    if not open_:
        none = f"participant {code} has no interrupted session to resume ({_listed(sessions)})"
        raise InputError(f"{none}: --new-session begins another")
    parts = sorted({session.part for session in open_})
    if len(parts) > 1:
        several = f"participant {code} has interrupted sessions of several parts ({', '.join(parts)})"
        raise InputError(f"{several}: choose one with --part NAME")
    return open_[-1]


def chosen_part(design: Design, part: str | None) -> str:
    """Return the part, by default the only one. Errors: InputError."""
    names = [part.name for part in design.parts]
    if part is None and len(names) == 1:
        return names[0]
    if part is None or part not in names:
        found = f"--part {part} is not in" if part else "--part is missing for"
        raise InputError(f"{found} {design.path or design.name}: it has {', '.join(names)}")
    return part
