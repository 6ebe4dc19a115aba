"""Ratings that the command line names: a table, a study's store, or published ones."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs

from ...errors import InputError
from ...report import counted
from ..design import ONLY_PART, SHIPPED, Ask, Design, Show, Step, every_scale, load_design, steps_of
from ..export import declined, long_rows, no_sessions, of_origin, plan_of, unconsented
from ..scales import PREFERENCE, RATING
from ..store import (
    COMPLETE,
    DATABASE,
    INTERRUPTED,
    PERSON,
    PILOT,
    RUNNING,
    SICK,
    STOPPED,
    Answer,
    Contents,
    Session,
    Showing,
    Store,
    folder_to_read,
    store_folder,
)
from .claims import Claims, load_claims
from .ratings import Preference, Rating, Ratings, ScaleInfo, SessionSummary, SurveyAnswer
from .table_ratings import SourceOptions, from_csv

# Scores of a task, analysed beside the ratings: by the name of a figure of study/actual.py.
TASK_MEASURES = {
    "task_target_s": ScaleInfo("task_target_s", "Time for each target found", low_is_good=True, unit="s"),
    "task_misses": ScaleInfo("task_misses", "Selections without a target", low_is_good=True, unit="selections"),
}
_WHY = {
    SICK: "the stop rule for sickness ended the session before",
    STOPPED: "the session was stopped before",
    INTERRUPTED: "the session was interrupted and not resumed",
    RUNNING: "the session is still running, or its program died",
    COMPLETE: "not answered",
}


def from_contents(contents: Contents, design: Design, origin: str = PERSON) -> Ratings:
    """Return the ratings of one origin, each with its place and the condition before it.

    origin: "person", "pilot" or "simulated". Every session is read by the plan that it ran with.
    Missing ratings are included, with the reason. Errors: InputError where there are no sessions.
    """
    kept = of_origin(contents, origin)
    sessions = kept.sessions
    if not sessions:
        raise InputError(no_sessions(contents, origin, "analyse"))
    latest = _latest(kept.answers)
    rows: list[Rating] = []
    survey: list[SurveyAnswer] = []
    preferences: list[Preference] = []
    summaries: list[SessionSummary] = []
    for session in sessions:
        plan = plan_of(session, design)
        answers = latest.get(session.id, {})
        of_session = _ratings(session, plan, answers)
        rows += of_session + _task_scores(session, plan, kept.showings)
        preferred = _preferences(session, plan, answers)
        preferences += preferred
        judged = {scale.name for scale in plan.scales if scale.kind in (RATING, PREFERENCE)}
        survey += [_survey_answer(session, one) for one in answers.values() if one.scale not in judged]
        trials = sum(len(names) for names in session.order)
        rated = {row.place for row in of_session if row.value is not None}
        rated |= {one.place for one in preferred if one.answer is not None}
        summaries.append(
            SessionSummary(session.sub, session.part, session.number, session.status, session.why, len(rated), trials)
        )
    found = Ratings(
        rows=tuple(rows),
        scale_info={scale.name: ScaleInfo.of(scale) for scale in design.scales if scale.kind == RATING}
        | (TASK_MEASURES if design.task is not None else {}),
        families=design.families,
        planned={part.name: tuple(one.name for one in part.conditions) for part in design.parts},
        origin=origin,
        source=f"the store of '{contents.name}'",
        title=design.title,
        sessions=tuple(summaries),
        survey=tuple(survey),
        preferences=tuple(preferences),
        scales={scale.name: scale for scale in every_scale(design)},
        notes=tuple(_notes(contents, sessions, design, origin)),
        long=tuple(long_rows(kept, design)),
    )
    return _without_part(found) if [part.name for part in design.parts] == [ONLY_PART] else found


def _without_part(ratings: Ratings) -> Ratings:
    """Drop the part's name where the plan has only one part and does not name it."""
    families = tuple(
        attrs.evolve(one, comparisons=tuple(attrs.evolve(c, part="") for c in one.comparisons))
        for one in ratings.families
    )
    return attrs.evolve(
        ratings,
        families=families,
        planned={"": ratings.planned[ONLY_PART]},
        rows=tuple(attrs.evolve(one, part="") for one in ratings.rows),
        sessions=tuple(attrs.evolve(one, part="") for one in ratings.sessions),
        survey=tuple(attrs.evolve(one, part="") for one in ratings.survey),
        preferences=tuple(attrs.evolve(one, part="") for one in ratings.preferences),
    )


def _latest(answers: Iterable[Answer]) -> dict[int, dict[str, Answer]]:
    """Return the last revision of each answer, by session and key."""
    found: dict[int, dict[str, Answer]] = {}
    for one in answers:
        of = found.setdefault(one.session, {})
        if one.key not in of or of[one.key].revision < one.revision:
            of[one.key] = one
    return found


def _ratings(session: Session, plan: Design, answers: Mapping[str, Answer]) -> list[Rating]:
    names = {scale.name for scale in plan.scales if scale.kind == RATING}
    steps = steps_of(plan, session.order, session.part)
    judged = _judged(steps)
    return [
        _rating(session, judged[ask.trial], _before(judged, ask.trial), ask, answers.get(ask.key))
        for ask in steps
        if isinstance(ask, Ask) and ask.phase == "trial" and ask.scale.name in names
    ]


def _judged(steps: Sequence[Step]) -> dict[int, Show]:
    """Return the showing that the questions of each trial are about, by trial: its last one."""
    return {step.trial: step for step in steps if isinstance(step, Show) and step.trial}


def _before(judged: Mapping[int, Show], trial: int) -> str:
    """Return the condition that was judged before a trial; "" for the first."""
    return judged[trial - 1].condition.name if trial - 1 in judged else ""


def _preferences(session: Session, plan: Design, answers: Mapping[str, Answer]) -> list[Preference]:
    steps = steps_of(plan, session.order, session.part)
    shows = {step.key: step for step in steps if isinstance(step, Show)}
    references = [one.name for one in plan.part(session.part).conditions if one.reference]
    found: list[Preference] = []
    for ask in steps:
        if not isinstance(ask, Ask) or ask.scale.kind != PREFERENCE:
            continue
        second, answer = shows[ask.about], answers.get(ask.key)
        found.append(
            Preference(
                participant=session.sub,
                part=session.part,
                scale=ask.scale.name,
                first=shows[second.after].condition.name,
                second=second.condition.name,
                answer=None if answer is None else answer.value,
                allows_ties=ask.scale.allows_ties,
                reference=next(iter(references), ""),
                why_missing=_why_missing(session, answer),
                repeat=second.repeat,
                place=ask.trial,
                session=session.number,
            )
        )
    return found


def _why_missing(session: Session, answer: Answer | None) -> str:
    """Return why an answer has no value; "" where it has one."""
    if answer is None:
        return _WHY[session.status]
    return "" if answer.value is not None else "the participant could not say"


def _task_scores(session: Session, plan: Design, showings: Iterable[Showing]) -> list[Rating]:
    """Return the scores of a session's task, of the last complete showing of each trial."""
    seen = {one.key: one.actual for one in showings if one.session == session.id and one.complete}
    rows: list[Rating] = []
    judged = _judged(steps_of(plan, session.order, session.part))
    for trial, show in judged.items():
        if show.task is None:
            continue
        actual = seen.get(show.key)
        why = _WHY[session.status] if actual is None else "no target was found"
        before = _before(judged, trial)
        for name in TASK_MEASURES:
            rows.append(_row(session, show, before, name, None if actual is None else actual.get(name), why))
    return rows


def _rating(session: Session, show: Show, before: str, ask: Ask, answer: Answer | None) -> Rating:
    value = None if answer is None else answer.value
    return _row(session, show, before, ask.scale.name, value, _why_missing(session, answer))


def _row(session: Session, show: Show, before: str, scale: str, value: float | None, why: str) -> Rating:
    """Return a value. why: it is missing, where it is None."""
    return Rating(
        participant=session.sub,
        part=session.part,
        condition=show.condition.name,
        scale=scale,
        value=value,
        why_missing="" if value is not None else why,
        reference=show.condition.reference,
        repeat=show.repeat,
        place=show.trial,
        previous=before,
        session=session.number,
        settings=_settings(show.condition.settings),
    )


def _settings(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Put the unit into the name, as tables have it."""
    return {"latency_ms" if name == "latency" else name: value for name, value in settings.items()}


def _survey_answer(session: Session, one: Answer) -> SurveyAnswer:
    return SurveyAnswer(session.sub, session.part, session.number, one.phase, one.trial, one.scale, one.item, one.value)


def _notes(contents: Contents, sessions: Sequence[Session], design: Design, origin: str) -> Iterable[str]:
    others = {session.origin for session in contents.sessions} - {origin}
    if origin != PERSON:
        yield f"These ratings are of origin '{origin}', not of people taking part in the study."
    if others:
        yield f"Sessions of origin {' and '.join(sorted(others))} are left out: origins are never mixed."
    changed = sum(session.plan != design.text for session in sessions)
    if changed:
        those = f"{changed} of {counted(len(sessions), 'session')}"
        yield f"The study's file was changed after {those}; each is read by the plan that it ran with."
    again = sum(count > 1 for count in Counter(session.sub for session in sessions).values())
    if again:
        yield f"Participants with more than one session: {again}; their ratings of a condition are averaged."
    if count := declined(contents, origin):
        yield f"Declined to take part, and counted nowhere else: {count}."
    if count := unconsented(contents, origin):
        yield f"Left before the consent was given, and counted nowhere else: {count}."
    if contents.withdrawn:
        yield f"Withdrawn, with all data erased: {contents.withdrawn}."


_PUBLISHED = (
    "These published ratings ship with hmdwarp; so do the figures published with them, which are compared with them."
)


def ratings_from(name: str, store: Path | None, options: SourceOptions) -> Ratings:
    """Return the ratings of a long table (a file) or of a study's store.

    A study is its .toml file, or a shipped one's name; a shipped study without a store stands for
    the ratings published with it. Errors: InputError where there is none of them.
    """
    if not name.endswith(".toml") and Path(name).is_file():
        return from_csv(Path(name), options)
    if name.endswith((".csv", ".tsv", ".txt")):
        raise InputError(
            f"{name}: no such file: expected a table of ratings, a study's .toml file, or a shipped study's name"
        )
    design = load_design(name, checked=False)
    origin = options.origin or PERSON
    published = SHIPPED / f"{name}_ratings.csv"
    if store is None and published.is_file() and not (store_folder(design, None, origin) / DATABASE).exists():
        known = attrs.evolve(
            options, scale=options.scale or next(one.name for one in design.scales if one.kind == RATING)
        )
        return attrs.evolve(from_csv(published, known), title=design.title)
    with Store(folder_to_read(design, store, origin), study=design.name) as data:
        contents = data.contents(pilot=origin == PILOT)
    return from_contents(contents, design, origin)


def claims_for(path: Path | None, ratings: Ratings, options: SourceOptions) -> tuple[Claims | None, str]:
    """Return the published figures to compare with, and a note if the user did not name them.

    They are those of the file, else those shipped for exactly these ratings, if any.
    """
    if path is not None:
        return load_claims(path), ""
    for table in sorted(SHIPPED.glob("*_ratings.csv")):
        claims = table.with_name(table.name.replace("_ratings.csv", "_claims.toml"))
        as_shipped = attrs.evolve(options, columns={}, origin="", scale="grade")
        if claims.is_file() and _values(from_csv(table, as_shipped)) == _values(ratings):
            return load_claims(claims), _PUBLISHED
    return None, ""


def _values(ratings: Ratings) -> set[tuple]:
    return {(row.part, row.participant, row.condition, row.value) for row in ratings.rows}
