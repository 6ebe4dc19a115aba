"""Rows of the exported tables from the store, missing ratings included; columns and formats."""

from __future__ import annotations

import csv
import importlib.util
import io
import json
import re
import tomllib
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
from ..scales import FIRST, NEITHER, PREFERENCE, RATING, SECOND, Scale, scored
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
    """Return COLUMNS, with the rows' other settings after SETTINGS, and `more` before the scale.

    RATED_COLUMNS are the last where a row has them.
    """
    others = [name for name in OTHER_SETTINGS if any(name in row for row in rows)]
    rated = [column.name for column in RATED_COLUMNS if any(row.get(column.name) is not None for row in rows)]
    before, after = LONG_COLUMNS.index(SETTINGS[-1]) + 1, LONG_COLUMNS
    names = (*after[:before], *others, *more, *after[before:], *rated)
    return tuple(column_of(name) for name in names)


def label_of(text: str) -> str:
    """Reduce a text to letters and digits, as BIDS labels must be; never empty."""
    return re.sub(r"[^A-Za-z0-9]", "", text) or "study"


def field_text(value: Any) -> str:
    """Format one value, n/a for a missing one.

    Numbers are the shortest text that reads back as the same one, whole ones without a point; texts
    are report.inert_text.
    """
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
    flat = (
        {name: " ".join(value.split()) if isinstance(value, str) else value for name, value in row.items()}
        for row in rows
    )
    return _text(flat, columns, "\t", "\n")


def _text(
    rows: Iterable[Mapping[str, Any]], columns: Sequence[Column], delimiter: str, line_end: Literal["\n", "\r\n"]
) -> str:
    stream = io.StringIO()
    writer = csv.writer(stream, delimiter=delimiter, lineterminator=line_end)
    writer.writerow([column.name for column in columns])
    writer.writerows([field_text(row.get(column.name)) for column in columns] for row in rows)
    return stream.getvalue()


def has_parquet() -> bool:
    """Return whether pyarrow is installed."""
    return importlib.util.find_spec("pyarrow") is not None


def write_parquet(path: Path, rows: Sequence[Mapping[str, Any]], columns: Sequence[Column], title: str) -> None:
    """Write typed columns, nulls for missing values, and descriptions as metadata.

    Errors: MachineError where pyarrow is missing; OSError.
    """
    pa, parquet = import_extra("pyarrow", "pyarrow", "study"), import_extra("pyarrow.parquet", "pyarrow", "study")
    types = {NUMBER: pa.float64(), INTEGER: pa.int64(), FLAG: pa.bool_()}
    fields = [pa.field(c.name, types.get(c.type, pa.string()), metadata=_metadata(c)) for c in columns]
    schema = pa.schema(fields, metadata={"title": title, "made_by": f"hmdwarp {__version__}", "missing": "null"})
    arrays = [
        pa.array([_typed(c, row.get(c.name)) for row in rows], field.type)
        for c, field in zip(columns, fields, strict=True)
    ]
    with path.open("wb") as file:
        # Not compressed, so that a search through the bytes finds an erased participant's data.
        parquet.write_table(pa.Table.from_arrays(arrays, schema=schema), file, compression="none")


def _metadata(column: Column) -> dict[str, str]:
    levels = json.dumps(dict(column.levels)) if column.levels else ""
    found = {"description": column.description, "units": column.units, "levels": levels}
    return {name: value for name, value in found.items() if value}


def _typed(column: Column, value: Any) -> Any:
    if value is None or value == "":
        return None
    if column.type == NUMBER:
        return float(value)
    return value if column.type in (INTEGER, FLAG) else str(value)


Row = dict[str, Any]
_DIGITS = 6  # of times in seconds: a clock of nanoseconds says more than anything shown

_OF_TRIAL = tuple(map(column_of, ("trial", "block", "repeat", "presentation")))
EVENTS = (*columns_in("events"), *_OF_TRIAL)
RUN_EVENTS = (*columns_in("run_events"), *EVENTS[1:])  # next to one recording of head motion
INPUT_EVENTS = (RUN_EVENTS[0], *columns_in("input_events"), *_OF_TRIAL, *columns_in("inputs"))


def input_rows(done: Iterable[InputEvent], start_ns: int) -> list[Row]:
    """Return rows by INPUT_EVENTS. start_ns: of the recording, on the inputs' clock."""
    names = [column.name for column in columns_in("inputs")]
    return [
        {"onset": round((each.time_ns - start_ns) * 1e-9, _DIGITS), "duration": 0}
        | dict(zip(names, (each.action, each.target, *each.origin_m, *each.direction), strict=True))
        for each in sorted(done, key=lambda each: each.time_ns)
    ]


def onset_s(session: Session, showing: Showing) -> float | None:
    """Return when the trial's first picture was seen, since the session began.

    Sessions of older versions have only the instant before it. None if the machine's clock was set
    back.
    """
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
    answers: Mapping[str, tuple[Answer, ...]]  # every revision, by key, in order
    showings: Mapping[int, Showing]  # by id

    @property
    def judged(self) -> dict[int, Show]:
        """The showing that the questions of each trial are about, by trial: its last one."""
        return {show.trial: show for show in self.shows.values() if show.trial}

    def previous(self, show: Show) -> str | None:
        """Return the condition that was judged before a trial; None for the first."""
        before = self.judged.get(show.trial - 1)
        return None if before is None else before.condition.name

    def last(self, ask: Ask) -> Answer | None:
        """Return the answer that counts, None without one."""
        return self.answers.get(ask.key, (None,))[-1]


def sessions_of(contents: Contents, design: Design) -> tuple[SessionData, ...]:
    """Return all sessions, each with the plan that it ran with.

    design: the present plan, which must know their conditions.
    Errors: InputError for a session of another plan.
    """
    read: dict[str, Design] = {design.text: design}
    for session in contents.sessions:
        if session.plan not in read:
            try:
                read[session.plan] = design_from_text(session.plan, design.path, checked=False)
            except InputError as error:
                raise InputError(
                    f"session {session.number} of participant {session.code} ran with a plan that this hmdwarp cannot "
                    f"read ({error}): export it with hmdwarp {session.facts.get('hmdwarp', '0.2')}, which ran it"
                ) from error
    return tuple(_session_data(contents, design, session, read[session.plan]) for session in contents.sessions)


def all_scales(contents: Contents, design: Design) -> dict[str, Scale]:
    """Return every scale of the plan and of the sessions, by name. Errors: as sessions_of."""
    asked = {ask.scale.name: ask.scale for data in sessions_of(contents, design) for ask in data.asks.values()}
    return {scale.name: scale for scale in every_scale(design)} | asked


def of_origin(contents: Contents, origin: str = PERSON) -> Contents:
    """Keep sessions of one origin: people, pilots and programs are never mixed.

    Sessions without consent are left out: they have no participant. The others come in the order of
    the random words, so that the order of arrival does not show.
    """
    chosen = (session for session in contents.sessions if session.origin == origin and session.consented)
    sessions = tuple(sorted(chosen, key=lambda session: (session.sub, session.number)))
    ids = {session.id for session in sessions}
    return attrs.evolve(
        contents,
        sessions=sessions,
        answers=tuple(answer for answer in contents.answers if answer.session in ids),
        showings=tuple(showing for showing in contents.showings if showing.session in ids),
        events=tuple(event for event in contents.events if event.session in ids),
    )


def declined(contents: Contents, origin: str = PERSON) -> int:
    """Return how many of that origin declined to take part, and did not take part later."""
    return len(_without_consent(contents, origin, declined=True))


def unconsented(contents: Contents, origin: str = PERSON) -> int:
    """Return how many more of that origin never gave the consent, nor refused it."""
    return len(_without_consent(contents, origin) - _without_consent(contents, origin, declined=True))


def _without_consent(contents: Contents, origin: str, *, declined: bool = False) -> set[str]:
    """Return who took no part. declined: only those who refused the consent."""
    of_them = [session for session in contents.sessions if session.origin == origin]
    some = {
        session.sub for session in of_them if not session.consented and (session.status == DECLINED or not declined)
    }
    return some - {session.sub for session in of_them if session.consented}


def answer_rows(contents: Contents, design: Design) -> list[Row]:
    """Return one row per planned question, with its `phase` and `kind`; None for a missing value.

    A missing answer has a row with the reason. Of revised answers only the last one counts.
    Errors: as sessions_of.
    """
    return [
        answer_row(design, data, ask, data.last(ask))
        for data in sessions_of(contents, design)
        for ask in data.asks.values()
    ]


def long_rows(answers: Iterable[Row]) -> list[Row]:
    """Return the ratings and choices after trials: the rows of the long table, by LONG_COLUMNS."""
    return [row for row in answers if row["phase"] == "trial" and row["kind"] in (RATING, PREFERENCE)]


def score_rows(contents: Contents, design: Design) -> list[Row]:
    """Return one row per score of the questionnaires: `item` is its name, `kind` "score"."""
    rows: list[Row] = []
    for data in sessions_of(contents, design):
        for phase, scales in (("before", data.plan.before), ("after", data.plan.after)):
            for scale in scales:
                asked = [ask for ask in data.asks.values() if ask.phase == phase and ask.scale.name == scale.name]
                last = [(ask, data.last(ask)) for ask in asked]
                values = {ask.item.key: None if answer is None else answer.value for ask, answer in last}
                base = answer_row(design, data, asked[0], last[0][1]) | {"seconds_to_answer": None, "revision": None}
                for name, value in scored(scale, values).items():
                    why = None if value is not None else NOT_ALL
                    rows.append(base | {"item": name, "value": value, "kind": "score", "why_missing": why})
    return rows


def _session_data(contents: Contents, design: Design, session: Session, plan: Design) -> SessionData:
    try:
        steps_of(design, session.order, session.part)
        steps = steps_of(plan, session.order, session.part)
    except StopIteration as error:
        raise InputError(
            f"study {design.name}: participant {session.code} saw the part '{session.part}' with conditions that "
            "this plan lacks: use the study file that the sessions ran with"
        ) from error
    answers: dict[str, list[Answer]] = {}
    for answer in sorted(
        (answer for answer in contents.answers if answer.session == session.id),
        key=lambda answer: (answer.revision, answer.id),
    ):
        answers.setdefault(answer.key, []).append(answer)
    return SessionData(
        session,
        plan,
        {step.key: step for step in steps if isinstance(step, Ask)},
        {step.key: step for step in steps if isinstance(step, Show)},
        {key: tuple(revisions) for key, revisions in answers.items()},
        {showing.id: showing for showing in contents.showings if showing.session == session.id},
    )


def answer_row(design: Design, data: SessionData, ask: Ask, answer: Answer | None) -> Row:
    session = data.session
    show = data.shows.get(ask.about)
    showing = _showing(data, ask, answer)
    value = None if answer is None else answer.value
    text = None if answer is None else ask.scale.words_for(ask.item, value, answer.text)
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
        "why_missing": None if value is not None or text else _why(session, answer),
        "seconds_to_answer": None if answer is None else _measured("seconds_to_answer", answer.seconds),
        "revision": None if answer is None else answer.revision,
        "presentation": None if showing is None else showing.presentation,
        "answered_by": None if answer is None else answer.by,
        **{
            f"actual_{name}": _measured(f"actual_{name}", value)
            for name, value in ({} if showing is None else showing.actual).items()
        },
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


def _why(session: Session, answer: Answer | None) -> str:
    if answer is not None:
        return CANNOT_SAY
    return NOT_ASKED if session.status == COMPLETE else f"session {session.status}"


def _showing(data: SessionData, ask: Ask, answer: Answer | None) -> Showing | None:
    """Return the showing that an answer is about; without an answer the last complete one."""
    if answer is not None and answer.showing is not None:
        return data.showings.get(answer.showing)
    whole = [showing for showing in data.showings.values() if showing.key == ask.about and showing.complete]
    return whole[-1] if whole else None


def _shown(data: SessionData, show: Show | None) -> Row:
    if show is None:
        return {"trial": None, "block": None, "repeat": None, "condition": None, "reference": None, "previous": None}
    return {
        "trial": show.trial,
        "block": show.block,
        "repeat": show.repeat,
        "condition": show.condition.name,
        "reference": show.condition.reference,
        "previous": data.previous(show),
        **settings_row(show.condition.settings),
    }


def settings_row(settings: Mapping[str, object]) -> Row:
    """Return a condition's settings as columns, with the defaults of a live run.

    Of a file only its name: its folder may name a person.
    """
    options = live_options(settings)
    row = {name: getattr(options, name) for name in SETTINGS}
    row["scene"] = PurePath(row["scene"]).name
    others = {name.replace("-", "_"): value for name, value in settings.items()}
    for name, value in others.items():
        if name not in (*SETTINGS, *DISPLAY, "latency"):
            row[name] = PurePath(str(value)).name if name in FILES else value
    return row
