"""Ratings that the command line names: a table, a study's store, or published ones."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import attrs

from ...errors import InputError
from ...report import counted
from ..design import ONLY_PART, SHIPPED, Ask, Design, every_scale, load_design
from ..export.export_rows import SessionData, declined, long_rows, of_origin, sessions_of, unconsented
from ..export.write import no_sessions
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
    Store,
    folder_to_read,
    store_folder,
)
from .comparisons import Claims, load_claims
from .ratings import Preference, Rating, Ratings, ScaleInfo, SessionSummary, SurveyAnswer
from .table_ratings import SourceOptions, from_csv

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
    if not kept.sessions:
        raise InputError(no_sessions(contents, origin, "analyse"))
    rows: list[Rating] = []
    survey: list[SurveyAnswer] = []
    preferences: list[Preference] = []
    summaries: list[SessionSummary] = []
    for data in sessions_of(kept, design):
        session = data.session
        who = (session.sub, session.part, session.number)
        rated = [_rating(data, ask) for ask in data.asks.values() if ask.phase == "trial" and ask.scale.kind == RATING]
        preferred = [_preference(data, ask) for ask in data.asks.values() if ask.scale.kind == PREFERENCE]
        rows += rated
        preferences += preferred
        judged = {scale.name for scale in data.plan.scales if scale.kind in (RATING, PREFERENCE)}
        survey += [
            SurveyAnswer(
                session.sub,
                session.part,
                session.number,
                answer.phase,
                answer.trial,
                answer.scale,
                answer.item,
                answer.value,
            )
            for *_, answer in data.answers.values()
            if answer.scale not in judged
        ]
        trials = sum(len(names) for names in session.order)
        done = {row.place for row in rated if row.value is not None}
        done |= {preference.place for preference in preferred if preference.answer is not None}
        summaries.append(SessionSummary(*who, session.status, session.why, len(done), trials))
    found = Ratings(
        rows=tuple(rows),
        scale_info={scale.name: ScaleInfo.of(scale) for scale in design.scales if scale.kind == RATING},
        families=design.families,
        planned={part.name: tuple(condition.name for condition in part.conditions) for part in design.parts},
        origin=origin,
        source=f"the store of '{contents.name}'",
        title=design.title,
        sessions=tuple(summaries),
        survey=tuple(survey),
        preferences=tuple(preferences),
        scales={scale.name: scale for scale in every_scale(design)},
        notes=tuple(_notes(contents, kept.sessions, design, origin)),
        long=tuple(long_rows(kept, design)),
    )
    return _without_part(found) if [part.name for part in design.parts] == [ONLY_PART] else found


def _without_part(ratings: Ratings) -> Ratings:
    """Drop the part's name where the plan has only one part and does not name it."""
    families = tuple(
        attrs.evolve(family, comparisons=tuple(attrs.evolve(c, part="") for c in family.comparisons))
        for family in ratings.families
    )
    without: dict[str, Any] = {
        name: tuple(attrs.evolve(row, part="") for row in getattr(ratings, name))
        for name in ("rows", "sessions", "survey", "preferences")
    }
    return attrs.evolve(ratings, families=families, planned={"": ratings.planned[ONLY_PART]}, **without)


def _rating(data: SessionData, ask: Ask) -> Rating:
    answer = data.last(ask)
    show = data.shows[ask.about]
    settings = show.condition.settings
    return Rating(
        participant=data.session.sub,
        part=data.session.part,
        condition=show.condition.name,
        scale=ask.scale.name,
        value=None if answer is None else answer.value,
        why_missing=_why_missing(data.session, answer),
        reference=show.condition.reference,
        repeat=show.repeat,
        place=show.trial,
        previous=data.previous(show) or "",
        session=data.session.number,
        # Tables have the unit in the name.
        settings={"latency_ms" if name == "latency" else name: value for name, value in settings.items()},
    )


def _preference(data: SessionData, ask: Ask) -> Preference:
    session, second, answer = data.session, data.shows[ask.about], data.last(ask)
    return Preference(
        participant=session.sub,
        part=session.part,
        scale=ask.scale.name,
        first=data.shows[second.after].condition.name,
        second=second.condition.name,
        answer=None if answer is None else answer.value,
        allows_ties=ask.scale.allows_ties,
        reference=next(
            (condition.name for condition in data.plan.part(session.part).conditions if condition.reference), ""
        ),
        why_missing=_why_missing(session, answer),
        repeat=second.repeat,
        place=ask.trial,
        session=session.number,
    )


def _why_missing(session: Session, answer: Answer | None) -> str:
    """Return why an answer has no value; "" where it has one."""
    if answer is None:
        return _WHY[session.status]
    return "" if answer.value is not None else "the participant could not say"


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
            options, scale=options.scale or next(scale.name for scale in design.scales if scale.kind == RATING)
        )
        return attrs.evolve(from_csv(published, known), title=design.title)
    with Store(folder_to_read(design, store, origin), study=design.name) as data:
        contents = data.contents(pilot=origin == PILOT)
    return from_contents(contents, design, origin)


def ratings_from_all(names: Sequence[str], store: Path | None, options: SourceOptions) -> Ratings:
    """Return the ratings of one source, or of several tables, as the exports of several sites.

    Errors: InputError as ratings_from; for several sources that are not all tables of one origin
    and the same scales, or where two have the same session.
    """
    if len(names) == 1:
        return ratings_from(names[0], store, options)
    found: dict[str, Ratings] = {}
    seen: dict[tuple[str, str, int], str] = {}
    for name in names:
        if name.endswith(".toml") or not Path(name).is_file():
            raise InputError(
                f"{name}: beside other sources expected a table of ratings that is there: export each study first "
                "('hmdwarp study export')"
            )
        found[name] = ratings = from_csv(Path(name), options)
        first = found[names[0]]
        if ratings.origin != first.origin:
            raise InputError(f"{name}: ratings of origin '{ratings.origin}', and '{first.origin}' in {names[0]}")
        for scale, info in ratings.scale_info.items():
            if first.scale_info.get(scale, info) != info:
                raise InputError(f"{name}: scale '{scale}' is another one than in {names[0]}")
        for who in {(row.participant, row.part, row.session) for row in ratings.rows}:
            if (other := seen.setdefault(who, name)) != name:
                raise InputError(
                    f"{name}: has session {who[2]} of participant '{who[0]}', as {other} has: is one a copy of the "
                    "other? Expected each rating once, and a name of their own for each person"
                )
    every = list(found.values())
    return attrs.evolve(
        every[0],
        rows=tuple(row for each in every for row in each.rows),
        scale_info={name: info for each in every for name, info in each.scale_info.items()},
        source=", ".join(each.source for each in every),
        title=", ".join(dict.fromkeys(each.title for each in every)),
        survey=tuple(answer for each in every for answer in each.survey),
        notes=tuple(dict.fromkeys(note for each in every for note in each.notes)),
        long=tuple(row for each in every for row in each.long),
    )


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


def _values(ratings: Ratings) -> set[tuple[Any, ...]]:
    return {(row.part, row.participant, row.condition, row.value) for row in ratings.rows}
