"""Short table of the ratings, and the trials as events of a BIDS data set."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from datetime import datetime
from typing import Any

from ..design import Show
from ..scales import FIRST, NEITHER, SECOND
from ..store import Session, Showing
from .table_columns import NUMBER, TEXT, Column, column_of

Row = dict[str, Any]
_DIGITS = 6  # of times in seconds: a clock of nanoseconds says more than anything shown

_ONSET = Column("onset", NUMBER, "From the start of the session to the first picture of the trial", "s")
_DURATION = Column("duration", NUMBER, "From the first picture of the trial to its last one", "s")
SHORT = (
    Column("ppid", TEXT, "The same as participant, as UXF names it"),
    *map(
        column_of,
        ("participant", "session", "part", "origin", "block", "trial", "repeat", "condition", "reference", "scale"),
    ),
    Column("rating", NUMBER, "The answer"),
    *map(column_of, ("low_is_good", "why_missing")),
    _ONSET,
    _DURATION,
    column_of("seconds_to_answer"),
)
PREFERENCES = (
    *SHORT[:8],
    Column("first", TEXT, "Condition shown first"),
    Column("second", TEXT, "Condition shown second"),
    column_of("scale"),
    Column("preferred", TEXT, "Condition that was preferred; neither where no difference was seen"),
    *SHORT[-4:],
)
NEITHER_WORD = "neither"
EVENTS = (
    _ONSET,
    _DURATION,
    Column("trial_type", TEXT, "Condition shown, or practice"),
    *map(column_of, ("trial", "block", "repeat", "presentation")),
)
# Beside one recording of head motion, which begins with the first picture.
RUN_EVENTS = (Column("onset", NUMBER, "From the first pose of the recording", "s"), *EVENTS[1:])


def short_rows(ratings: Iterable[Row]) -> list[Row]:
    """Return rows by SHORT. ratings: as export_rows.long_rows."""
    return [{**row, "ppid": row["participant"], "rating": row["value"]} for row in ratings]


def preference_rows(asked: Iterable[tuple[Row, Show, Show]]) -> list[Row]:
    """Return rows by PREFERENCES. asked: rows as export_rows.answer_rows, with both showings."""
    rows = []
    for row, first, second in asked:
        names = {FIRST: first.condition.name, SECOND: second.condition.name, NEITHER: NEITHER_WORD, None: None}
        pair = {"first": names[FIRST], "second": names[SECOND], "preferred": names[row["value"]]}
        rows.append({**row, **pair, "ppid": row["participant"]})
    return rows


def onset_s(session: Session, showing: Showing) -> float | None:
    """Return when the trial's first picture was seen, since the session began.

    Sessions of older versions have only the instant before it. None if the machine's clock was set
    back.
    """
    if showing.actual.get("onset_s") is not None:
        return round(showing.actual["onset_s"], _DIGITS)
    passed = datetime.fromisoformat(showing.started_utc) - datetime.fromisoformat(session.started_utc)
    return None if passed.total_seconds() < 0 else passed.total_seconds()


def event_rows(session: Session, shows: Mapping[str, Show], showings: Iterable[Showing]) -> list[Row]:
    """Return a row by EVENTS for each of the showings whose onset is known, in that order."""
    rows = [_event(shows[one.key], one, onset_s(session, one)) for one in showings]
    return sorted((row for row in rows if row["onset"] is not None), key=lambda row: row["onset"])


def duration_s(showing: Showing) -> float | None:
    """Return the time from the trial's first picture to its last one."""
    seconds = showing.actual.get("seconds")
    return None if seconds is None else round(seconds, _DIGITS)


def _event(show: Show, showing: Showing, onset: float | None) -> Row:
    return {
        "onset": onset,
        "duration": duration_s(showing),
        "trial_type": show.condition.name,
        "trial": show.trial,
        "block": show.block,
        "repeat": show.repeat,
        "presentation": showing.presentation,
    }
