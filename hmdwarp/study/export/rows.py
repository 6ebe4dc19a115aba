"""From what the store has to rows of tables: one for each rating, the missing ones among them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import PurePath
from typing import Any

import attrs

from ...errors import InputError
from ..design import Ask, Design, Show, steps_of
from ..design.read import design_from_text
from ..design.settings import DISPLAY, FILES, live_options
from ..scales import QUESTIONNAIRE, RATING, Scale, scored
from ..store import COMPLETE, PERSON, Answer, Contents, Session, Showing
from .columns import CANNOT_SAY, NOT_ALL, NOT_ASKED, SETTINGS

Row = dict[str, Any]
_FIELDS = {
    "latency_ms": "latency_ms",
    "warp": "warp",
    "fill": "fill",
    "scene": "scene",
    "effects": "effects",
    "lens": "lens",
}


@attrs.frozen(eq=False)
class Sitting:
    """One session with everything that belongs to it. plan: the one it was run by. asks: all questions it was to have, by key; shows alike.
    answers: every revision, by key, the first one first. showings: by id."""

    session: Session
    plan: Design
    asks: Mapping[str, Ask]
    shows: Mapping[str, Show]
    answers: Mapping[str, tuple[Answer, ...]]
    showings: Mapping[int, Showing]


def sittings(contents: Contents, design: Design) -> tuple[Sitting, ...]:
    """All sessions, as contents has them, each by the plan it was run by. design: the present plan, which has to know their conditions.
    Errors: InputError for a session of another plan."""
    read: dict[str, Design] = {design.text: design}
    for session in contents.sessions:
        if session.plan not in read:
            read[session.plan] = plan_of(session, design)
    return tuple(_sitting(contents, design, session, read[session.plan]) for session in contents.sessions)


def plan_of(session: Session, design: Design) -> Design:
    """What the session was run by: the file as it was then, where that is another than the present one. Errors: InputError."""
    return design if session.plan == design.text else design_from_text(session.plan, design.path, checked=False)


def scales_asked(contents: Contents, design: Design) -> dict[str, Scale]:
    """Every scale of the plan and of the sessions, by name. Errors: as sittings."""
    asked = {ask.scale.name: ask.scale for sitting in sittings(contents, design) for ask in sitting.asks.values()}
    sickness = () if design.sickness is None else (design.sickness.scale,)
    return {scale.name: scale for scale in (*design.scales, *sickness, *design.before, *design.after)} | asked


def of_origin(contents: Contents, origin: str = PERSON) -> Contents:
    """Without everybody else: people, pilots and programs never stand in one table. In the order of the random words: who came first is
    nobody's business."""
    chosen = (one for one in contents.sessions if one.origin == origin)
    sessions = tuple(sorted(chosen, key=lambda one: (one.sub, one.number)))
    ids = {one.id for one in sessions}
    kept = {
        name: tuple(one for one in getattr(contents, name) if one.session in ids)
        for name in ("answers", "showings", "events")
    }
    return attrs.evolve(contents, sessions=sessions, **kept)


def long_rows(contents: Contents, design: Design) -> list[Row]:
    """One row for each rating after a trial, by the names of columns.LONG_COLUMNS; None where a value is missing.

    A rating that was to be and is not has a row too, which says why. Of revised answers only the last one. Errors: as sittings.
    """
    return [row for row in answer_rows(contents, design) if row["phase"] == "trial" and row["kind"] == RATING]


def answer_rows(contents: Contents, design: Design) -> list[Row]:
    """As long_rows, for every question of a session: `phase` and `kind` tell which is which."""
    return [
        _row(design, sitting, ask, _last(sitting, ask))
        for sitting in sittings(contents, design)
        for ask in sitting.asks.values()
    ]


def revision_rows(contents: Contents, design: Design) -> list[Row]:
    """One row for each answer that was ever confirmed, those that were revised later too, in the order of the questions."""
    return [
        _row(design, sitting, ask, answer)
        for sitting in sittings(contents, design)
        for ask in sitting.asks.values()
        for answer in sitting.answers.get(ask.key, ())
    ]


def score_rows(contents: Contents, design: Design) -> list[Row]:
    """What the questionnaires come to: a row for each score, `item` being its name, `kind` "score"."""
    rows: list[Row] = []
    for sitting in sittings(contents, design):
        for phase, scales in (("before", sitting.plan.before), ("after", sitting.plan.after)):
            for scale in scales:
                asked = [ask for ask in sitting.asks.values() if ask.phase == phase and ask.scale.name == scale.name]
                last = [(ask, _last(sitting, ask)) for ask in asked]
                values = {ask.item.key: None if answer is None else answer.value for ask, answer in last}
                base = _row(design, sitting, asked[0], last[0][1]) | {"seconds_to_answer": None, "revision": None}
                for name, value in scored(scale, values).items():
                    why = None if value is not None else NOT_ALL
                    rows.append(base | {"item": name, "value": value, "kind": "score", "why_missing": why})
    return rows


def questionnaire_rows(contents: Contents, design: Design) -> list[Row]:
    """Answers to questionnaires, and their scores after them."""
    answers = [row for row in answer_rows(contents, design) if row["kind"] == QUESTIONNAIRE]
    return answers + score_rows(contents, design)


def _sitting(contents: Contents, design: Design, session: Session, plan: Design) -> Sitting:
    try:
        steps_of(design, session.order, session.part)
        steps = steps_of(plan, session.order, session.part)
    except StopIteration as error:
        raise InputError(
            f"study {design.name}: participant {session.code} saw the part '{session.part}' with conditions that this plan has not: "
            "give the study file that the sessions were run with"
        ) from error
    answers: dict[str, list[Answer]] = {}
    for answer in sorted(
        (one for one in contents.answers if one.session == session.id), key=lambda one: (one.revision, one.id)
    ):
        answers.setdefault(answer.key, []).append(answer)
    return Sitting(
        session,
        plan,
        {step.key: step for step in steps if isinstance(step, Ask)},
        {step.key: step for step in steps if isinstance(step, Show)},
        {key: tuple(given) for key, given in answers.items()},
        {one.id: one for one in contents.showings if one.session == session.id},
    )


def _last(sitting: Sitting, ask: Ask) -> Answer | None:
    return sitting.answers.get(ask.key, (None,))[-1]


def _row(design: Design, sitting: Sitting, ask: Ask, answer: Answer | None) -> Row:
    session = sitting.session
    show = sitting.shows.get(ask.about)
    showing = _showing(sitting, ask, answer)
    value = None if answer is None else answer.value
    return {
        "study": design.name,
        "participant": session.sub,
        "session": session.number,
        "part": session.part,
        "origin": session.origin,
        "status": session.status,
        "order": session.row,
        **_shown(sitting, show),
        "phase": ask.phase,
        "kind": ask.scale.kind,
        "scale": ask.scale.name,
        "item": ask.item.key,
        "value": value,
        "low_is_good": ask.scale.low_is_good,
        "why_missing": None if value is not None else _why(session, answer),
        "seconds_to_answer": None if answer is None else answer.seconds,
        "revision": None if answer is None else answer.revision,
        "presentation": None if showing is None else showing.presentation,
        "answered_by": None if answer is None else answer.by,
        **({} if showing is None else {f"actual_{name}": value for name, value in showing.actual.items()}),
        **({} if showing is None else {f"measured_{name}": value for name, value in showing.measured.items()}),
    }


def _why(session: Session, answer: Answer | None) -> str:
    if answer is not None:
        return CANNOT_SAY
    return NOT_ASKED if session.status == COMPLETE else f"session {session.status}"


def _showing(sitting: Sitting, ask: Ask, answer: Answer | None) -> Showing | None:
    """The one the answer is about; without an answer the last one that came to its end."""
    if answer is not None and answer.showing is not None:
        return sitting.showings.get(answer.showing)
    whole = [one for one in sitting.showings.values() if one.key == ask.about and one.complete]
    return whole[-1] if whole else None


def _shown(sitting: Sitting, show: Show | None) -> Row:
    if show is None:
        return {"trial": None, "repeat": None, "condition": None, "reference": None, "previous": None}
    before = {one.trial: one.condition.name for one in sitting.shows.values() if one.trial}
    return {
        "trial": show.trial,
        "repeat": show.repeat,
        "condition": show.condition.name,
        "reference": show.condition.reference,
        "previous": before.get(show.trial - 1),
        **settings_row(show.condition.settings),
    }


def settings_row(settings: Mapping[str, object]) -> Row:
    """A condition's settings as columns, with the defaults of a live run; of a file only its name, for its folder may name somebody."""
    options = live_options(settings)
    row = {name: getattr(options, _FIELDS[name]) for name in SETTINGS}
    row["scene"] = PurePath(row["scene"]).name
    others = {name.replace("-", "_"): value for name, value in settings.items()}
    for name, value in others.items():
        if name not in (*SETTINGS, *DISPLAY, "latency"):
            row[name] = PurePath(str(value)).name if name in FILES else value
    return row
