"""Ratings from a study's own store."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import attrs

from ...errors import InputError
from ...report import counted
from ..design import Ask, Design, Show, steps_of
from ..design._parts import ONLY_PART
from ..export.rows import long_rows, of_origin, plan_of
from ..export.words import nobody
from ..scales import RATING, Scale
from ..store import COMPLETE, INTERRUPTED, PERSON, RUNNING, SICK, STOPPED, Answer, Contents, Session
from .ratings import Felt, Measure, Rating, Ratings, Sitting

_WHY = {
    SICK: "the stop rule for sickness ended the session before",
    STOPPED: "the session was stopped before",
    INTERRUPTED: "the session was interrupted and not gone on with",
    RUNNING: "the session is still running, or its program died",
    COMPLETE: "not answered",
}
_CANNOT_SAY = "the participant could not say"


def from_contents(contents: Contents, design: Design, origin: str = PERSON) -> Ratings:
    """The ratings of one origin, each with its place and the condition before it.

    origin: "person", "pilot" or "simulated". Every session is read by the plan it was run by. What was not rated is there too, with the
    reason. Errors: InputError where there are no such sessions.
    """
    # By their random words: who came first is nobody's business.
    sessions = sorted((one for one in contents.sessions if one.origin == origin), key=lambda one: (one.sub, one.number))
    if not sessions:
        raise InputError(nobody(contents, origin, "analyse"))
    latest = _latest(contents.answers)
    rows: list[Rating] = []
    felt: list[Felt] = []
    sittings: list[Sitting] = []
    for session in sessions:
        plan = plan_of(session, design)
        known = latest.get(session.id, {})
        found = _ratings(session, plan, known)
        rows += found
        rating = {scale.name for scale in plan.scales if scale.kind == RATING}
        felt += [_felt(session, one) for one in known.values() if one.scale not in rating]
        trials = sum(len(names) for names in session.order)
        rated = len({row.place for row in found if row.value is not None})
        sittings.append(Sitting(session.sub, session.part, session.number, session.status, session.why, rated, trials))
    found = Ratings(
        rows=tuple(rows),
        measures={scale.name: Measure.of(scale) for scale in design.scales if scale.kind == RATING},
        families=design.families,
        planned={part.name: tuple(one.name for one in part.conditions) for part in design.parts},
        origin=origin,
        source=f"the store of '{contents.name}'",
        title=design.title,
        sittings=tuple(sittings),
        felt=tuple(felt),
        others=_others(design),
        notes=tuple(_notes(contents, sessions, design, origin)),
        long=tuple(long_rows(of_origin(contents, origin), design)),
    )
    return _without_part(found) if [part.name for part in design.parts] == [ONLY_PART] else found


def _others(design: Design) -> dict[str, Scale]:
    asked = (
        *design.scales,
        *design.before,
        *design.after,
        *(() if design.sickness is None else (design.sickness.scale,)),
    )
    return {scale.name: scale for scale in asked}


def _without_part(ratings: Ratings) -> Ratings:
    """The same under no name of a part: the plan has none, so nothing said of it needs one."""
    families = (
        attrs.evolve(one, comparisons=tuple(attrs.evolve(c, part="") for c in one.comparisons))
        for one in ratings.families
    )
    lists = {
        name: tuple(attrs.evolve(one, part="") for one in getattr(ratings, name))
        for name in ("rows", "sittings", "felt")
    }
    return attrs.evolve(ratings, families=tuple(families), planned={"": ratings.planned[ONLY_PART]}, **lists)


def _latest(answers: Iterable[Answer]) -> dict[int, dict[str, Answer]]:
    """By session and key, the revision that counts."""
    found: dict[int, dict[str, Answer]] = {}
    for one in answers:
        of = found.setdefault(one.session, {})
        if one.key not in of or of[one.key].revision < one.revision:
            of[one.key] = one
    return found


def _ratings(session: Session, plan: Design, known: Mapping[str, Answer]) -> list[Rating]:
    names = {scale.name for scale in plan.scales if scale.kind == RATING}
    rows: list[Rating] = []
    show: Show | None = None
    before = ""
    for step in steps_of(plan, session.order, session.part):
        if isinstance(step, Show) and step.trial:
            before, show = (show.condition.name if show else ""), step
        elif (
            isinstance(step, Ask)
            and step.trial
            and show is not None
            and step.scale.name in names
            and step.phase == "trial"
        ):
            answer = known.get(step.key)
            rows.append(
                Rating(
                    participant=session.sub,
                    part=session.part,
                    condition=show.condition.name,
                    scale=step.scale.name,
                    value=None if answer is None else answer.value,
                    why_missing=_WHY[session.status]
                    if answer is None
                    else ("" if answer.value is not None else _CANNOT_SAY),
                    reference=show.condition.reference,
                    repeat=show.repeat,
                    place=step.trial,
                    previous=before,
                    session=session.number,
                    settings=_settings(show.condition.settings),
                )
            )
    return rows


def _settings(settings: Mapping[str, Any]) -> dict[str, Any]:
    """With the unit in the name, as tables have it."""
    return {"latency_ms" if name == "latency" else name: value for name, value in settings.items()}


def _felt(session: Session, one: Answer) -> Felt:
    return Felt(session.sub, session.part, session.number, one.phase, one.trial, one.scale, one.item, one.value)


def _notes(contents: Contents, sessions: list[Session], design: Design, origin: str) -> Iterable[str]:
    others = {session.origin for session in contents.sessions} - {origin}
    if origin != PERSON:
        yield f"These ratings are of origin '{origin}', not of people taking part in the study."
    if others:
        yield f"Sessions of origin {' and '.join(sorted(others))} are left out: they never count together."
    changed = sum(session.plan != design.text for session in sessions)
    if changed:
        those = f"{changed} of {counted(len(sessions), 'session')}"
        yield f"The study's file was changed after {those}; each is read by the plan it was run by."
    again = len({session.sub for session in sessions if session.number > 1})
    if again:
        yield f"Participants with more than one session: {again}; their ratings of a condition are averaged over all of them."
    if contents.withdrawn:
        yield f"Withdrawn, with nothing left of their data: {contents.withdrawn}."
