"""Rows of the exported tables from the store, missing ratings included; columns and formats."""

from __future__ import annotations

import csv
import io
import json
import re
import tomllib
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from datetime import datetime
from pathlib import Path, PurePath
from typing import Any, Literal

import attrs

from ...errors import InputError
from ...metrics import metrics_in_order
from ...report import inert_text
from ...resources import __version__, import_extra
from ...scenes import ACTIONS, InputEvent
from ..actual import COUNTS, FLAGS, NUMBERS, TEXTS
from ..design import DISPLAY, FILES, KINDS, Ask, Design, Show, design_from_text, every_scale, live_options, steps_of
from ..scales import FIRST, NEITHER, PREFERENCE, SECOND, Scale, scored
from ..scales import KINDS as SCALE_KINDS
from ..store import COMPLETE, DECLINED, ORIGINS, PERSON, STATUSES, UNCONSENTED, Answer, Contents, Session, Showing

TEXT, NUMBER, INTEGER, FLAG = "text", "number", "whole", "flag"
MISSING = "n/a"
CANNOT_SAY, NOT_ASKED, NOT_ALL = "cannot say", "not asked", "answers missing"
PHASES = ("before", "practice", "trial", "after")


@attrs.frozen
class Column:
    """One column of a table."""

    name: str
    type: str  # TEXT, NUMBER, INTEGER or FLAG
    description: str
    units: str = ""  # as BIDS writes them, "" for none
    levels: Mapping[str, str] = attrs.field(factory=dict, hash=False)  # descriptions of the values


_SAID = tomllib.loads(Path(__file__).with_name("columns.toml").read_text(encoding="utf-8"))
# Values whose descriptions columns.toml has in this order.
_VALUES = {"origin": ORIGINS, "status": STATUSES, "phase": PHASES, "kind": (*SCALE_KINDS, "score"), "action": ACTIONS}
_LEVELS = {name: dict(zip(values, _SAID["levels"][name], strict=True)) for name, values in _VALUES.items()} | {
    "why_missing": {
        CANNOT_SAY: "the participant could not say",
        NOT_ASKED: "the session ended without the question",
        NOT_ALL: "answers that the score needs are missing",
        **{
            f"session {status}": "the session ended before the answer"
            for status in STATUSES
            if status not in (COMPLETE, DECLINED, UNCONSENTED)
        },
    }
}


def columns_in(group: str) -> tuple[Column, ...]:
    """Return the columns of a table of columns.toml."""
    return tuple(
        Column(name, kind, text, "".join(unit), _LEVELS.get(name, {}))
        for name, (kind, text, *unit) in _SAID[group].items()
    )


_UNITS = (("_ms", "ms"), ("_hz", "Hz"), ("_deg_s", "deg/s"), ("_m_s", "m/s"), ("_s", "s"), ("_db", "dB"))
_OF = {"_median": "median", "_p95": "95th percentile", "_sd": "standard deviation", "_mean": "mean"}


def _actual(name: str) -> Column:
    if name in TEXTS:
        return Column(f"actual_{name}", TEXT, f"As it was shown: {_SAID['texts'].get(name, name)}")
    stem, how = next(
        ((name.removesuffix(end), f", {word}") for end, word in _OF.items() if name.endswith(end)), (name, "")
    )
    text, *units = _SAID["actual"].get(stem, (stem.replace("_", " "),))
    unit = [*units, *(u for end, u in _UNITS if stem.endswith(end)), ""][0]
    kind = FLAG if name in FLAGS else INTEGER if name in COUNTS else NUMBER
    return Column(f"actual_{name}", kind, f"As it was shown: {text}{how}", unit)


ACTUAL_COLUMNS = tuple(_actual(name) for name in (*NUMBERS, *FLAGS, *TEXTS))
MEASURED_COLUMNS = (
    *(
        Column(f"measured_{m.name}", NUMBER, f"Afterwards, mean of the measured pictures: {m.description}", m.unit)
        for m in metrics_in_order()
    ),
    *columns_in("measured"),
)
RATED_COLUMNS, _SETTING_COLUMNS = (*columns_in("pair"), *columns_in("rated")), columns_in("settings")
SETTINGS = tuple(column.name for column in _SETTING_COLUMNS)
COLUMNS = (
    *columns_in("who"),
    *columns_in("what"),
    *_SETTING_COLUMNS,
    *columns_in("shown"),
    *ACTUAL_COLUMNS,
    *MEASURED_COLUMNS,
)
LONG_COLUMNS = tuple(column.name for column in COLUMNS)

# Settings besides SETTINGS: columns of studies that use them.
OTHER_SETTINGS = tuple(name for name in KINDS if name not in (*DISPLAY, *SETTINGS, "latency"))
_BY_NAME = {column.name: column for column in (*COLUMNS, *RATED_COLUMNS, *columns_in("phase"))}


def column_of(name: str) -> Column:
    """Return the column of that name, by default a setting of a study."""
    if name in _BY_NAME:
        return _BY_NAME[name]
    kind = {"a number": NUMBER, "a whole number": INTEGER, "true or false": FLAG}.get(KINDS.get(name, ""), TEXT)
    return Column(name, kind, f"Setting of the condition: --{name.replace('_', '-')} of hmdwarp live")


def columns_for(rows: Sequence[Mapping[str, Any]], more: Sequence[str] = ()) -> tuple[Column, ...]:
    """Return COLUMNS with the rows' other settings, `more` before the scale, RATED_COLUMNS last."""
    others = [name for name in OTHER_SETTINGS if any(name in row for row in rows)]
    rated = [column.name for column in RATED_COLUMNS if any(row.get(column.name) is not None for row in rows)]
    before, after = LONG_COLUMNS.index(SETTINGS[-1]) + 1, LONG_COLUMNS
    names = (*after[:before], *others, *more, *after[before:], *rated)
    return tuple(column_of(name) for name in names)


def label_of(text: str) -> str:
    """Reduce a text to letters and digits, as BIDS labels must be; never empty."""
    return re.sub(r"[^A-Za-z0-9]", "", text) or "study"


def field_text(value: Any) -> str:
    """Format a value as report.inert_text, n/a for none; numbers read back as the same."""
    if value is None or value == "":
        return MISSING
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return str(int(value)) if value.is_integer() and abs(value) < 2**53 else repr(float(value))
    return inert_text(str(value))


def csv_text(rows: Iterable[Mapping[str, Any]], columns: Sequence[Column]) -> str:
    """Return CSV: commas, CRLF, quotes around a comma, a quote or a line end."""
    return _text(rows, columns, ",", "\r\n")


def tsv_text(rows: Iterable[Mapping[str, Any]], columns: Sequence[Column]) -> str:
    """Return TSV: tabs, LF. TSV has no quotes, so tabs and line ends in a value become spaces."""
    rows = [{name: " ".join(v.split()) if isinstance(v, str) else v for name, v in row.items()} for row in rows]
    return _text(rows, columns, "\t", "\n")


def _text(
    rows: Iterable[Mapping[str, Any]], columns: Sequence[Column], delimiter: str, line_end: Literal["\n", "\r\n"]
) -> str:
    stream = io.StringIO()
    writer = csv.writer(stream, delimiter=delimiter, lineterminator=line_end)
    writer.writerow([column.name for column in columns])
    writer.writerows([field_text(row.get(column.name)) for column in columns] for row in rows)
    return stream.getvalue()


def write_parquet(path: Path, rows: Sequence[Mapping[str, Any]], columns: Sequence[Column], title: str) -> None:
    """Write typed columns, nulls for missing values, and descriptions as metadata."""
    pa, parquet = import_extra("pyarrow", "pyarrow", "study"), import_extra("pyarrow.parquet", "pyarrow", "study")
    kinds = {NUMBER: (pa.float64(), float), INTEGER: (pa.int64(), int), FLAG: (pa.bool_(), bool)}
    fields, arrays = [], []
    for column in columns:
        type_, of = kinds.get(column.type, (pa.string(), str))
        levels = json.dumps(dict(column.levels)) if column.levels else ""
        about = {"description": column.description, "units": column.units, "levels": levels}
        fields.append(pa.field(column.name, type_, metadata={name: text for name, text in about.items() if text}))
        values = [row.get(column.name) for row in rows]
        arrays.append(pa.array([None if value in (None, "") else of(value) for value in values], type_))
    schema = pa.schema(fields, metadata={"title": title, "made_by": f"hmdwarp {__version__}", "missing": "null"})
    with path.open("wb") as file:
        # Not compressed, so that a search through the bytes finds an erased participant's data.
        parquet.write_table(pa.Table.from_arrays(arrays, schema=schema), file, compression="none")


Row = dict[str, Any]
_DIGITS = 6  # of times in seconds: a clock of nanoseconds says more than anything shown

_OF_TRIAL = tuple(map(column_of, ("trial", "block", "repeat", "presentation")))
EVENTS = (*columns_in("events"), *_OF_TRIAL)
RUN_EVENTS = (*columns_in("run_events"), *EVENTS[1:])  # next to one recording of head motion
INPUT_EVENTS = (RUN_EVENTS[0], *columns_in("input_events"), *_OF_TRIAL, *columns_in("inputs"))


def input_rows(done: Iterable[InputEvent], start_ns: int) -> list[Row]:
    """Return rows by INPUT_EVENTS. start_ns: of the recording, on the inputs' clock."""
    names = ("onset", "duration", *(column.name for column in columns_in("inputs")))
    values = (
        (round((one.time_ns - start_ns) * 1e-9, _DIGITS), 0, one.action, one.target, *one.origin_m, *one.direction)
        for one in sorted(done, key=lambda one: one.time_ns)
    )
    return [dict(zip(names, row, strict=True)) for row in values]


def onset_s(session: Session, showing: Showing) -> float | None:
    """Return when the first picture was seen, in the session; None if the clock was set back."""
    if showing.actual.get("onset_s") is not None:
        return float(round(showing.actual["onset_s"], _DIGITS))
    passed = datetime.fromisoformat(showing.started_utc) - datetime.fromisoformat(session.started_utc)
    return None if passed.total_seconds() < 0 else passed.total_seconds()


def event_rows(session: Session, shows: Mapping[str, Show], showings: Iterable[Showing]) -> list[Row]:
    """Return a row by EVENTS for each of the showings whose onset is known, in that order."""
    names = [column.name for column in EVENTS]
    rows: list[Row] = []
    for showing in showings:
        show, onset, seconds = shows[showing.key], onset_s(session, showing), showing.actual.get("seconds")
        duration = None if seconds is None else round(seconds, _DIGITS)
        about = (show.condition.name, show.trial, show.block, show.repeat, showing.presentation)
        rows += [] if onset is None else [dict(zip(names, (onset, duration, *about), strict=True))]
    return sorted(rows, key=lambda row: row["onset"])


@attrs.frozen(eq=False)
class SessionData:
    """One session with its plan and all its data."""

    session: Session
    plan: Design  # that it ran with
    asks: Mapping[str, Ask]  # all planned questions, by key
    shows: Mapping[str, Show]  # all planned showings, by key
    answers: Mapping[str, Answer]  # the last revision, which counts, by key
    showings: Mapping[int, Showing]  # by id


def sessions_of(contents: Contents, design: Design) -> tuple[SessionData, ...]:
    """Return all sessions, each with its own plan. design: the present one, for conditions."""
    read: dict[str, Design] = {design.text: design}
    answers, showings = defaultdict[int, dict[str, Answer]](dict), defaultdict[int, dict[int, Showing]](dict)
    for answer in sorted(contents.answers, key=lambda answer: (answer.revision, answer.id)):
        answers[answer.session][answer.key] = answer
    for showing in contents.showings:
        showings[showing.session][showing.id] = showing
    found = []
    for session in contents.sessions:
        if session.plan not in read:
            try:
                read[session.plan] = design_from_text(session.plan, design.path, checked=False)
            except InputError as error:
                raise InputError(
                    f"session {session.number} of participant {session.code} ran with a plan that this hmdwarp cannot "
                    f"read ({error}): export it with hmdwarp {session.facts.get('hmdwarp', '0.2')}, which ran it"
                ) from error
        plan = read[session.plan]
        try:
            steps_of(design, session.order, session.part)
            steps = steps_of(plan, session.order, session.part)
        except StopIteration as error:
            raise InputError(
                f"study {design.name}: participant {session.code} saw the part '{session.part}' with conditions that "
                "this plan lacks: use the study file that the sessions ran with"
            ) from error
        asks = {step.key: step for step in steps if isinstance(step, Ask)}
        shows = {step.key: step for step in steps if isinstance(step, Show)}
        found.append(SessionData(session, plan, asks, shows, answers[session.id], showings[session.id]))
    return tuple(found)


def all_scales(contents: Contents, design: Design) -> dict[str, Scale]:
    """Return every scale of the plan and of the sessions, by name. Errors: as sessions_of."""
    asked = {ask.scale.name: ask.scale for data in sessions_of(contents, design) for ask in data.asks.values()}
    return {scale.name: scale for scale in every_scale(design)} | asked


def of_origin(contents: Contents, origin: str = PERSON) -> Contents:
    """Keep sessions of one origin and with consent: people, pilots and programs are never mixed.

    They come in the order of the random words, so that the order of arrival does not show.
    """
    chosen = (session for session in contents.sessions if session.origin == origin and session.consented)
    sessions = tuple(sorted(chosen, key=lambda session: (session.sub, session.number)))
    ids = {session.id for session in sessions}
    kept: dict[str, Any] = {
        name: tuple(row for row in getattr(contents, name) if row.session in ids)
        for name in ("answers", "showings", "events")
    }
    return attrs.evolve(contents, sessions=sessions, **kept)


def without_consent(contents: Contents, origin: str = PERSON) -> tuple[int, int]:
    """Return how many of that origin refused the consent, and how many more never gave it."""
    of_them = [session for session in contents.sessions if session.origin == origin]
    took_part = {session.sub for session in of_them if session.consented}
    refused = {session.sub for session in of_them if session.status == DECLINED} - took_part
    return len(refused), len({session.sub for session in of_them} - took_part - refused)


def answer_rows(contents: Contents, design: Design) -> list[Row]:
    """Return one row per planned question, with the reason where it has no answer."""
    return [answer_row(design, data, ask) for data in sessions_of(contents, design) for ask in data.asks.values()]


def score_rows(contents: Contents, design: Design) -> list[Row]:
    """Return one row per score of the questionnaires: `item` is its name, `kind` "score"."""
    rows: list[Row] = []
    for data in sessions_of(contents, design):
        for phase, scales in (("before", data.plan.before), ("after", data.plan.after)):
            for scale in scales:
                asked = [ask for ask in data.asks.values() if ask.phase == phase and ask.scale.name == scale.name]
                given = {ask.item.key: data.answers.get(ask.key) for ask in asked}
                values = {key: None if answer is None else answer.value for key, answer in given.items()}
                base = answer_row(design, data, asked[0]) | {"seconds_to_answer": None, "revision": None}
                for name, value in scored(scale, values).items():
                    why = None if value is not None else NOT_ALL
                    rows.append(base | {"item": name, "value": value, "kind": "score", "why_missing": why})
    return rows


def answer_row(design: Design, data: SessionData, ask: Ask) -> Row:
    """Return the row of a planned question, with the showing that its answer is about."""
    session, answer, show = data.session, data.answers.get(ask.key), data.shows.get(ask.about)
    if answer is not None and answer.showing is not None:
        showing = data.showings.get(answer.showing)
    else:
        whole = [one for one in data.showings.values() if one.key == ask.about and one.complete]
        showing = whole[-1] if whole else None
    value = None if answer is None else answer.value
    text = None if answer is None else ask.scale.words_for(ask.item, value, answer.text)
    why = NOT_ASKED if session.status == COMPLETE else f"session {session.status}"
    return {
        "study": design.name,
        "participant": session.sub,
        "session": session.number,
        "part": session.part,
        "origin": session.origin,
        "status": session.status,
        "order": session.row,
        **_shown(data, show),
        **(_chosen(data, show, value) if show is not None and ask.scale.kind == PREFERENCE else {}),
        "phase": ask.phase,
        "kind": ask.scale.kind,
        "scale": ask.scale.name,
        "item": ask.item.key,
        "value": value,
        "text": text,
        "low_is_good": None if ask.item.answer else ask.scale.low_is_good,
        "why_missing": None if value is not None or text else why if answer is None else CANNOT_SAY,
        "seconds_to_answer": None if answer is None else _measured("seconds_to_answer", answer.seconds),
        "revision": None if answer is None else answer.revision,
        "presentation": None if showing is None else showing.presentation,
        "answered_by": None if answer is None else answer.by,
        **({} if showing is None else {f"actual_{k}": _measured(f"actual_{k}", v) for k, v in showing.actual.items()}),
        **({} if showing is None else {f"measured_{name}": value for name, value in showing.measured.items()}),
    }


def _chosen(data: SessionData, second: Show, value: float | None) -> Row:
    """Return what a pair showed first, and which of both was preferred."""
    first = data.shows[second.after].condition.name
    names = {FIRST: first, SECOND: second.condition.name, NEITHER: "neither", None: None}
    return {"first": first, "preferred": names[value]}


def _measured(column: str, value: Any) -> Any:
    """Round a time to the nanosecond of its clock: sums of floats show digits beyond it."""
    digits = {"s": 9, "ms": 6}.get(column_of(column).units)
    return round(value, digits) if digits is not None and isinstance(value, float) else value


def _shown(data: SessionData, show: Show | None) -> Row:
    """Return what was judged: the last showing of a trial, which its questions are about."""
    if show is None:
        return dict.fromkeys(("trial", "block", "repeat", "condition", "reference", "previous"))
    judged = {one.trial: one.condition.name for one in data.shows.values() if one.trial}
    about = {"trial": show.trial, "block": show.block, "repeat": show.repeat, "condition": show.condition.name}
    about |= {"reference": show.condition.reference, "previous": judged.get(show.trial - 1)}
    return about | settings_row(show.condition.settings)


def settings_row(settings: Mapping[str, object]) -> Row:
    """Return a condition's settings with defaults; a file's name alone: folders name people."""
    options = live_options(settings)
    row = {name: getattr(options, name) for name in SETTINGS}
    row["scene"] = PurePath(row["scene"]).name
    others = {name.replace("-", "_"): value for name, value in settings.items()}
    for name, value in others.items():
        if name not in (*SETTINGS, *DISPLAY, "latency"):
            row[name] = PurePath(str(value)).name if name in FILES else value
    return row
