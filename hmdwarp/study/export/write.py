"""Exports a study into one folder, whole or not at all: tables, a README and a BIDS data set.

First the rows of the tables from the store, missing ratings included, with columns and formats.
"""

from __future__ import annotations

import csv
import importlib.util
import io
import json
import re
import tomllib
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from datetime import datetime, timedelta
from pathlib import Path, PurePath
from typing import Any, Literal

import attrs
import numpy as np

from ...base import InputError, TraceError, __version__, import_extra, install_line, made_text
from ...metrics import metrics_in_order
from ...poses import PoseTrack, load_trace
from ...report import OutputFolder, counted, inert_text
from ...run import DESKTOP, OPENXR
from ...scenes import ACTIONS, InputEvent, inputs_beside, read_inputs
from .. import store as stored
from ..actual import COUNTS, FLAGS, NUMBERS, TEXTS
from ..design import DISPLAY, FILES, KINDS, Ask, Design, Show, design_from_text, every_scale, live_options, steps_of
from ..scales import FIRST, NEITHER, PREFERENCE, RATING, SECOND, Scale, scored
from ..scales import KINDS as SCALE_KINDS
from ..store import COMPLETE, DECLINED, PERSON, PILOT, SIMULATED, Answer, Contents, Session, Showing

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
_VALUES = {
    "origin": stored.ORIGINS,
    "status": stored.STATUSES,
    "phase": PHASES,
    "kind": (*SCALE_KINDS, "score"),
    "action": ACTIONS,
}
_LEVELS = {name: dict(zip(values, _SAID["levels"][name], strict=True)) for name, values in _VALUES.items()} | {
    "why_missing": {
        CANNOT_SAY: "the participant could not say",
        NOT_ASKED: "the session ended without the question",
        NOT_ALL: "answers that the score needs are missing",
        **{
            f"session {status}": "the session ended before the answer"
            for status in stored.STATUSES
            if status not in (COMPLETE, DECLINED, stored.UNCONSENTED)
        },
    }
}


def _columns_in(group: str) -> tuple[Column, ...]:
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


_ACTUAL_COLUMNS = tuple(_actual(name) for name in (*NUMBERS, *FLAGS, *TEXTS))
_MEASURED_COLUMNS = (
    *(
        Column(f"measured_{m.name}", NUMBER, f"Afterwards, mean of the measured pictures: {m.description}", m.unit)
        for m in metrics_in_order()
    ),
    *_columns_in("measured"),
)
RATED_COLUMNS, _SETTING_COLUMNS = (*_columns_in("pair"), *_columns_in("rated")), _columns_in("settings")
SETTINGS = tuple(column.name for column in _SETTING_COLUMNS)
COLUMNS = (
    *_columns_in("who"),
    *_columns_in("what"),
    *_SETTING_COLUMNS,
    *_columns_in("shown"),
    *_ACTUAL_COLUMNS,
    *_MEASURED_COLUMNS,
)
LONG_COLUMNS = tuple(column.name for column in COLUMNS)

# Settings besides SETTINGS: columns of studies that use them.
_OTHER_SETTINGS = tuple(name for name in KINDS if name not in (*DISPLAY, *SETTINGS, "latency"))
_BY_NAME = {column.name: column for column in (*COLUMNS, *RATED_COLUMNS, *_columns_in("phase"))}


def column_of(name: str) -> Column:
    """Return the column of that name, by default a setting of a study."""
    if name in _BY_NAME:
        return _BY_NAME[name]
    kind = {"a number": NUMBER, "a whole number": INTEGER, "true or false": FLAG}.get(KINDS.get(name, ""), TEXT)
    return Column(name, kind, f"Setting of the condition: --{name.replace('_', '-')} of hmdwarp live")


def columns_for(rows: Sequence[Mapping[str, Any]], more: Sequence[str] = ()) -> tuple[Column, ...]:
    """Return COLUMNS with the rows' other settings, `more` before the scale, RATED_COLUMNS last."""
    others = [name for name in _OTHER_SETTINGS if any(name in row for row in rows)]
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


def _write_parquet(path: Path, rows: Sequence[Mapping[str, Any]], columns: Sequence[Column], title: str) -> None:
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
EVENTS = (*_columns_in("events"), *_OF_TRIAL)
_RUN_EVENTS = (*_columns_in("run_events"), *EVENTS[1:])  # next to one recording of head motion
INPUT_EVENTS = (_RUN_EVENTS[0], *_columns_in("input_events"), *_OF_TRIAL, *_columns_in("inputs"))


def _input_rows(done: Iterable[InputEvent], start_ns: int) -> list[Row]:
    """Return rows by INPUT_EVENTS. start_ns: of the recording, on the inputs' clock."""
    names = ("onset", "duration", *(column.name for column in _columns_in("inputs")))
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


def _event_rows(session: Session, shows: Mapping[str, Show], showings: Iterable[Showing]) -> list[Row]:
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
class _SessionData:
    """One session with its plan and all its data."""

    session: Session
    plan: Design  # that it ran with
    asks: Mapping[str, Ask]  # all planned questions, by key
    shows: Mapping[str, Show]  # all planned showings, by key
    answers: Mapping[str, Answer]  # the last revision, which counts, by key
    showings: Mapping[int, Showing]  # by id


def sessions_of(contents: Contents, design: Design) -> tuple[_SessionData, ...]:
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
        found.append(_SessionData(session, plan, asks, shows, answers[session.id], showings[session.id]))
    return tuple(found)


def _all_scales(contents: Contents, design: Design) -> dict[str, Scale]:
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


def answer_row(design: Design, data: _SessionData, ask: Ask) -> Row:
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


def _chosen(data: _SessionData, second: Show, value: float | None) -> Row:
    """Return what a pair showed first, and which of both was preferred."""
    first = data.shows[second.after].condition.name
    names = {FIRST: first, SECOND: second.condition.name, NEITHER: "neither", None: None}
    return {"first": first, "preferred": names[value]}


def _measured(column: str, value: Any) -> Any:
    """Round a time to the nanosecond of its clock: sums of floats show digits beyond it."""
    digits = {"s": 9, "ms": 6}.get(column_of(column).units)
    return round(value, digits) if digits is not None and isinstance(value, float) else value


def _shown(data: _SessionData, show: Show | None) -> Row:
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


# --- the folder

FRAME = "world"
# name, component, type, units: in the order of the columns of _motion.tsv.
CHANNELS = (
    ("latency", "n/a", "LATENCY", "s"),
    ("head_pos_x", "x", "POS", "m"),
    ("head_pos_y", "y", "POS", "m"),
    ("head_pos_z", "z", "POS", "m"),
    ("head_quat_x", "quat_x", "ORNT", "n/a"),
    ("head_quat_y", "quat_y", "ORNT", "n/a"),
    ("head_quat_z", "quat_z", "ORNT", "n/a"),
    ("head_quat_w", "quat_w", "ORNT", "n/a"),
)
_NO_CHANNELS = ("ACCEL", "ANGACCEL", "GYRO", "JNTANG", "MAGN", "MISC", "VEL")
_UNEVEN = 0.05  # of a median step: smaller deviations are the timer's


def tracking_system(facts: Mapping[str, Any]) -> tuple[str, str, str]:
    """Return what led the head of a showing: a label, a name, and the device's model or "".

    A window's headset is only emulated. A trace's file name stays private: it may name a person.
    """
    display, axes = facts.get("display", {}), facts.get("trace_axes")
    if facts.get("trace"):
        return "trace", f"head trace, replayed{f'; its axes: {axes}' if axes else ''}", ""
    if facts.get("source") == OPENXR:
        model = display.get("headset", "")
        return "hmd", f"{model or 'headset'}, by OpenXR runtime {_runtime(display) or 'unknown'}", model
    if facts.get("source") == DESKTOP:
        return "mouse", "mouse and keyboard of a desktop window", ""
    return "unknown", "not recorded", ""


def motion_text(track: PoseTrack) -> str:
    """Return the _motion.tsv: no header, a row for each sample, columns as CHANNELS.

    Seconds to the microsecond, as the specification writes them; poses with every digit.
    """
    stream = io.StringIO()
    columns = (track.time_ns - track.start_ns, track.position_m, track.orientation_xyzw)
    for time_ns, position, orientation in zip(*(column.tolist() for column in columns), strict=True):
        whole, micro = divmod((time_ns + 500) // 1000, 1_000_000)
        stream.write("\t".join((f"{whole}.{micro:06d}", *map(repr, position), *map(repr, orientation))) + "\n")
    return stream.getvalue()


def motion_json(track: PoseTrack, task: Mapping[str, str], facts: Mapping[str, Any]) -> dict[str, Any]:
    """Return the sidecar; of the session's facts only versions and what led the head are used."""
    (_, system, model), steps = tracking_system(facts), np.diff(track.time_ns)
    median = float(np.median(steps))
    uneven, longest_s = (np.abs(steps - median) > _UNEVEN * median).mean(), steps.max() * 1e-9
    return {
        **task,
        "SamplingFrequency": round(1e9 / median, 6),
        "SamplingFrequencyEffective": round(len(steps) * 1e9 / track.duration_ns, 6),
        "SamplingDescription": f"Samples are as recorded, not resampled: {uneven:.1%} of the steps differ by more than "
        f"{_UNEVEN:.0%} from the median, the longest is {longest_s:.4f} s. The channel 'latency' holds the instant of "
        "each.",
        "TrackingSystemName": system,
        "RecordingDuration": round(track.duration_ns * 1e-9, 6),
        "MotionChannelCount": len(CHANNELS),
        "LATENCYChannelCount": 1,
        "POSChannelCount": 3,
        "ORNTChannelCount": 4,
        **{f"{kind}ChannelCount": 0 for kind in _NO_CHANNELS},
        "TrackedPointsCount": 1,
        "MissingValues": "n/a",
        "SubjectArtefactDescription": "n/a",
        "Manufacturer": "n/a",
        "ManufacturersModelName": model or "n/a",
        "DeviceSerialNumber": "n/a",  # would identify the machine
        "SoftwareVersions": software(facts.get("hmdwarp", ""), facts.get("display", {})),
    }


def software(hmdwarp: str, display: Mapping[str, Any]) -> str:
    """Name the versions of hmdwarp and of the runtime, as far as known."""
    return ", ".join(filter(None, (f"hmdwarp {hmdwarp}".strip(), _runtime(display))))


def _runtime(display: Mapping[str, Any]) -> str:
    return " ".join(str(display[key]) for key in ("runtime", "runtime_version") if display.get(key))


def channels_text() -> str:
    """Return the _channels.tsv: one row for each column of _motion.tsv, in that order."""
    rows = ["name\tcomponent\ttype\ttracked_point\tunits\treference_frame"]
    rows += [
        f"{name}\t{component}\t{type_}\thead\t{units}\t{'n/a' if type_ == 'LATENCY' else FRAME}"
        for name, component, type_, units in CHANNELS
    ]
    return "\n".join(rows) + "\n"


def channels_json() -> dict[str, Any]:
    """Describe the reference frame."""
    text = (
        "world_from_head in the axes of OpenXR: +x right, +y up, +z backward, metres; the quaternion rotates from "
        "the head's axes to the world's. The origin is the display's own."
    )
    frame = {"SpatialAxes": "RSP", "RotationRule": "right-hand", "Description": text}
    return {"reference_frame": {"Description": "Axes of the channel", "Levels": {FRAME: frame}}}


VERSION = "1.9.0"
FOLDER = "bids"
_EPOCH = datetime(1925, 1, 1)  # BIDS: dates shifted for privacy lie in 1925 or before
Progress = Callable[[int, int], None]

_PARTICIPANTS = _columns_in("participants")
_SCANS = _columns_in("scans")


def write_bids(
    out: OutputFolder,
    contents: Contents,
    design: Design,
    rows: Sequence[Row],
    readme: str,
    progress: Progress,
    *,
    motion: bool = True,
) -> tuple[int, list[str]]:
    """Write the data set, with the head motion if `motion`.

    contents: of one origin. rows: all answers (answer_rows and score_rows) of all sessions.
    Returns how many recordings were written, and why others were left out.
    """
    shows = {data.session.id: data.shows for data in sessions_of(contents, design)}
    tree = _Tree(out, contents, design, label_of(design.name), _all_scales(contents, design), shows)
    tree.head(readme)
    # One that was cut off was repeated, and no answer is about it: its poses stay in the store.
    recorded = [showing for showing in contents.showings if motion and showing.complete and showing.trace]
    written, left_out = 0, list[str]()
    for session in contents.sessions:
        own = [row for row in rows if (row["participant"], row["session"]) == (session.sub, session.number)]
        files = tree.behaviour(session, own)
        for showing in (showing for showing in recorded if showing.session == session.id):
            try:
                files.append(tree.motion(session, showing, len(files)))
                written += 1
            except (InputError, FileNotFoundError) as error:
                left_out.append(f"{showing.trace}: {str(error).splitlines()[0]}")
            progress(written + len(left_out), len(recorded))
        tree.scans(session, files)
    return written, left_out


@attrs.frozen
class _Tree:
    out: OutputFolder
    contents: Contents
    design: Design
    task: str
    scales: dict[str, Scale]
    shows: dict[int, Mapping[str, Show]]  # planned showings of each session, by key

    def head(self, readme: str) -> None:
        """Write the files of the whole data set."""
        self._json("dataset_description.json", {
            "Name": self.design.title,
            "BIDSVersion": VERSION,
            "DatasetType": "raw",
            "GeneratedBy": [{"Name": "hmdwarp", "Version": __version__, "Description": made_text()}],
        })  # fmt: skip
        self.out.write_text(f"{FOLDER}/README", readme)
        people: dict[str, list[Session]] = {}
        for session in self.contents.sessions:
            people.setdefault(session.sub, []).append(session)
        # By the random word, so that the order of arrival does not show.
        rows = [{
            "participant_id": f"sub-{sub}",
            "part": ", ".join(dict.fromkeys(session.part for session in sessions)),
            "origin": sessions[-1].origin,
            "sessions": len(sessions),
            "status": sessions[-1].status,
        } for sub, sessions in sorted(people.items())]  # fmt: skip
        self._text("participants.tsv", tsv_text(rows, _PARTICIPANTS))
        gone, side = self.contents.withdrawn, sidecar(_PARTICIPANTS)
        if gone and all(session.origin == PERSON for session in self.contents.sessions):  # their origin is not known
            side["Withdrawn"] = {"Description": f"{gone} withdrew; all their data were erased", "Count": gone}
        self._json("participants.json", side)

    def behaviour(self, session: Session, rows: Sequence[Row]) -> list[Row]:
        """Write a session's answers and the times of its trials; return the rows for _scans.tsv."""
        stem = f"beh/{self._stem(session)}"
        columns = columns_for(rows, ("phase", "kind", *(["text"] if any(row["text"] for row in rows) else [])))
        self._text(f"{self._folder(session)}/{stem}_beh.tsv", tsv_text(rows, columns))
        self._json(f"{self._folder(session)}/{stem}_beh.json", self._task(session) | sidecar(columns, self.scales))
        shown = (showing for showing in self.contents.showings if showing.session == session.id and showing.complete)
        self._events(session, stem, _event_rows(session, self.shows[session.id], shown))
        return [{"filename": f"{stem}_beh.tsv", "acq_time": _shifted(session.started_utc, session.started_utc)}]

    def _events(self, session: Session, stem: str, rows: Sequence[Row], columns: Sequence[Column] = EVENTS) -> None:
        self._text(f"{self._folder(session)}/{stem}_events.tsv", tsv_text(rows, columns))
        machine = session.facts.get("machine", {})
        system = " ".join(str(machine[key]) for key in ("system", "release") if key in machine)
        made_by = {"SoftwareName": "hmdwarp", "SoftwareVersion": session.facts.get("hmdwarp", __version__)}
        self._json(
            f"{self._folder(session)}/{stem}_events.json",
            self._task(session)
            | {"StimulusPresentation": {"OperatingSystem": system or "n/a", **made_by}}
            | sidecar(columns),
        )

    def motion(self, session: Session, showing: Showing, run: int) -> Row:
        """Write the head motion of a showing, and what was done in it. Errors: InputError."""
        trace = self.contents.folder / "traces" / showing.trace
        track, acted = load_trace(trace).track, inputs_beside(trace)
        if len(track) < 2:
            raise TraceError("a single pose is no motion")
        facts = self._facts(session, showing)
        events = [row | {"onset": 0.0} for row in _event_rows(session, self.shows[session.id], [showing])]
        columns = _RUN_EVENTS
        if acted.is_file():
            try:
                events += _input_rows(read_inputs(acted), track.start_ns + track.epoch_ns)
            except InputError as error:
                how = "mend that line, or delete the file to do without, and export again with --force"
                raise InputError(f"{error}; {how}") from error
            columns = INPUT_EVENTS
        self._events(session, f"motion/{self._stem(session)}_run-{run:02d}", events, columns)
        stem = f"motion/{self._stem(session)}_tracksys-{tracking_system(facts)[0]}_run-{run:02d}"
        folder = self._folder(session)
        self._text(f"{folder}/{stem}_motion.tsv", motion_text(track))
        self._json(f"{folder}/{stem}_motion.json", motion_json(track, self._task(session), facts))
        self._text(f"{folder}/{stem}_channels.tsv", channels_text())
        self._json(f"{folder}/{stem}_channels.json", channels_json())
        return {
            "filename": f"{stem}_motion.tsv",
            "acq_time": _shifted(session.started_utc, showing.started_utc),
            "trial": showing.trial,
            "condition": showing.condition,
            "presentation": showing.presentation,
        }

    def _facts(self, session: Session, showing: Showing) -> Mapping[str, Any]:
        """Return the facts of the run of the program that showed it; a session may be resumed."""
        facts, shown = session.facts, (showing.key, showing.presentation)
        for event in self.contents.events:  # in their order: the clock may have been set back meanwhile
            if event.session != session.id:
                continue
            if event.kind == "showing" and (event.key, event.data["presentation"]) == shown:
                break
            facts = (event.kind == "resume" and event.data) or facts
        return facts

    def scans(self, session: Session, files: Sequence[Row]) -> None:
        """List the files with their times since the beginning of the session."""
        name = f"{self._folder(session)}/sub-{session.sub}_ses-{session.number:02d}_scans"
        self._text(f"{name}.tsv", tsv_text(files, _SCANS))
        self._json(f"{name}.json", sidecar(_SCANS))

    def _task(self, session: Session) -> dict[str, Any]:
        asked = (scale.prompt or scale.items[0].text for scale in self.design.scales)
        return {
            "TaskName": self.design.name,
            "TaskDescription": f"{self.design.title} Conditions are shown one after the other, and rated after each.",
            "Instructions": " ".join(["After each trial:", *asked]),
            "SoftwareVersions": software(session.facts.get("hmdwarp", __version__), session.facts.get("display", {})),
        }

    def _folder(self, session: Session) -> str:
        return f"sub-{session.sub}/ses-{session.number:02d}"

    def _stem(self, session: Session) -> str:
        return f"sub-{session.sub}_ses-{session.number:02d}_task-{self.task}"

    def _text(self, name: str, text: str) -> None:
        self.out.write_text(f"{FOLDER}/{name}", text)

    def _json(self, name: str, value: dict[str, Any]) -> None:
        self.out.write_json(f"{FOLDER}/{name}", value)


def sidecar(columns: Sequence[Column], scales: dict[str, Scale] | None = None) -> dict[str, Any]:
    """Describe columns, and the values of the scales, for a JSON sidecar."""
    out: dict[str, Any] = {}
    for column in columns:
        out[column.name] = {"Description": column.description}
        if column.levels:
            out[column.name]["Levels"] = dict(column.levels)
        if column.units:
            out[column.name]["Units"] = column.units
    if scales and "scale" in out:
        out["scale"]["Levels"] = {name: _about(scale) for name, scale in scales.items()}
        items = {item.key: item.described for scale in scales.values() for item in scale.items}
        out["item"]["Levels"] = items | {
            score.name: score.title or score.name for scale in scales.values() for score in scale.scores
        }
    return out


def _about(scale: Scale) -> str:
    if not scale.has_answers:
        return scale.title
    words = ", ".join(f"{value:g} {word}" for value, word in scale.anchors.items())
    anchors, source = f" ({words})" if words else "", f"; source: {scale.source}" if scale.source else ""
    return f"{scale.title}: {scale.least:g} to {scale.most:g} by {scale.step:g}, {scale.direction}{anchors}{source}"


def _shifted(start_utc: str, at_utc: str) -> str | None:
    """Shift an instant of a session to 1925; None if the machine's clock was set back meanwhile."""
    passed = datetime.fromisoformat(at_utc) - datetime.fromisoformat(start_utc)
    return (_EPOCH + passed).isoformat(timespec="milliseconds") if passed >= timedelta(0) else None


# Older versions wrote some of them; a forced export removes what they hold of withdrawn people.
OWNED = (
    *("ratings.*", "ratings_short.csv", "sessions/*.csv", "preferences.csv", "sickness.tsv", "questionnaires.tsv"),
    *("revisions.tsv", "remarks.csv", "columns.json", "bids/**/*"),
)


_WHOSE = {
    PERSON: ("a person", "people"),
    PILOT: ("a pilot, who tried the study out", "pilots, who tried the study out"),
    SIMULATED: ("a program that answered instead of a person", "programs that answered instead of people"),
}
_OF_MOTION = """Head motion is personal data all the same: minutes of it identify a person among
hundreds. Give the folder bids/ only to recipients to whom the participants agreed."""
_ONE = {PERSON: "person", PILOT: "pilot", SIMULATED: "simulated participant"}


@attrs.frozen
class ExportOptions:
    """What to export."""

    origin: str = PERSON  # one of store.ORIGINS
    parquet: bool | None = None  # True: an error where it cannot be written; None: if possible
    force: bool = False  # into a folder that holds files; those of an older export go
    motion: bool = True  # write the head motion too


@attrs.frozen
class _Exported:
    """Result of an export."""

    folder: Path
    notes: tuple[str, ...]  # what was written, in sentences


def export(
    contents: Contents,
    design: Design,
    out: Path,
    options: ExportOptions | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> _Exported:
    """Export a study.

    out: a new or empty folder, unless forced: an older export may hold people who have withdrawn
    since.
    Errors: InputError for a folder that is not empty, a study without such sessions, or a plan that
    is not theirs; MachineError for a full disk, and where Parquet is required and pyarrow is
    missing.
    """
    options = options or ExportOptions()
    kept = of_origin(contents, options.origin)
    if not kept.sessions:
        raise InputError(no_sessions(contents, options.origin, "export"))
    if not options.force and out.is_dir() and any(out.iterdir()):
        raise InputError(
            f"{out}: exists and is not empty: an older export may hold participants who have withdrawn since; "
            "choose another folder, or replace it with --force"
        )
    answers = answer_rows(kept, design)
    kinds = (RATING, PREFERENCE)
    ratings = [row for row in answers if row["phase"] == "trial" and row["kind"] in kinds]
    with OutputFolder(out, owned=OWNED, last="README", force=options.force, private=True) as folder:
        notes = [_counts(kept, ratings, options.origin)]
        if changed := sum(session.plan != design.text for session in kept.sessions):
            ran = "each is written by the plan it ran with"
            notes.append(f"the study's file was changed after {counted(changed, 'session')}: {ran}")
        said = ("declined to take part", "left before the consent was given")
        for count, what in zip(without_consent(contents, options.origin), said, strict=True):
            notes += [f"{counted(count, 'person')} {what}: in no table"] if count else []
        notes += _tables(folder, kept, design, answers, ratings, options.parquet)
        text = _readme(design, kept, ratings, options)
        rows = [*answers, *score_rows(kept, design)]
        written, left_out = write_bids(folder, kept, design, rows, text, progress, motion=options.motion)
        recordings = f"with {counted(written, 'recording')} of head motion: personal data"
        notes.append(f"bids/: a BIDS data set {recordings if options.motion else 'without head motion'}")
        notes += [f"left out: {why}" for why in left_out]
        folder.write_text("README", text)
    return _Exported(Path(out), tuple(notes))


def _tables(
    folder: OutputFolder,
    contents: Contents,
    design: Design,
    answers: Sequence[Row],
    ratings: Sequence[Row],
    parquet: bool | None,
) -> list[str]:
    columns = columns_for(ratings)
    folder.write_bytes("ratings.csv", csv_text(ratings, columns).encode())
    described = columns_for(answers, ("phase", "kind", "text"))
    folder.write_json("columns.json", sidecar(described, _all_scales(contents, design)))
    notes = ["ratings.csv: one row for each rating"]
    if parquet is None and importlib.util.find_spec("pyarrow") is None:
        return [*notes, f"no ratings.parquet: the package pyarrow is not installed ({install_line('study')})"]
    if parquet is not False:
        _write_parquet(folder.path("ratings.parquet"), ratings, columns, design.title)
        notes.append("ratings.parquet: the same with typed columns")
    return notes


def _counts(contents: Contents, ratings: Sequence[Row], origin: str) -> str:
    people = len({session.sub for session in contents.sessions})
    rated = sum(row["value"] is not None for row in ratings)
    missing = f", {len(ratings) - rated} missing" if len(ratings) > rated else ""
    whose = _WHOSE[origin][people != 1]
    sessions, ratings_ = counted(len(contents.sessions), "session"), counted(rated, "rating")
    return f"{counted(people, 'participant')} ({whose}) in {sessions}, {ratings_}{missing}"


def no_sessions(contents: Contents, origin: str, verb: str) -> str:
    """Say that there are no sessions of that origin to `verb`, and what to do."""
    there = {session.origin for session in contents.sessions if session.consented} - {origin}
    run = "run one with --pilot" if origin == PILOT else "run one"
    hint = f"{run} first, or check the folder of --store"
    if PERSON in there:
        hint = f"it holds sessions of people: leave out --{origin}"
    elif there:
        other = min(there)
        hint = f"it holds {other} ones: use --{other}"
    elif none := sum(without_consent(contents, origin)):
        hint = f"{counted(none, 'session')} ended without the consent, and count nowhere; {hint}"
    return f"{contents.folder}: no session of a {_ONE[origin]} to {verb}: {hint}"


def _readme(design: Design, contents: Contents, ratings: Sequence[Row], options: ExportOptions) -> str:
    scales = ", ".join(
        f"{scale.name} ({scale.least:g} to {scale.most:g}, {scale.direction})" if scale.has_answers else scale.name
        for scale in design.scales
    )
    conditions = "\n".join(
        f"  {part.name}: {', '.join(condition.name for condition in part.conditions)}" for part in design.parts
    )
    return f"""{design.title}

Study "{design.name}", exported by hmdwarp {__version__} ({made_text()}): {_counts(contents, ratings, options.origin)}.
Asked after each trial: {scales}.
Conditions, by part of the study:
{conditions}

ratings.csv, and ratings.parquet where pyarrow is installed: the same table with one row per rating,
missing ones included, and what was shown. columns.json: meaning, units and values of each column.
bids/: a BIDS data set with all answers, those between the trials and to questionnaires included,
{"with" if options.motion else "without"} the motion of the heads.
In bids/ authors, licence and institution are left for you to fill in.
Missing values are n/a, in Parquet null. Numbers have decimal points. Of corrected answers the last
one counts. A text that begins with = + - or @ (blanks, apostrophes, a tab or a line end before it
count as well) and is no number has an apostrophe put before it, so that no spreadsheet runs it:
take that one off for the text as it was typed, as 'hmdwarp study analyse' does. Parquet has it as
typed.

Privacy: participants are random words, which cannot be traced back from this folder. It holds no
date and no time of day: instants count from the beginning of a session, which BIDS writes as
1925-01-01. {_OF_MOTION if options.motion else "It holds no head motion."}
Participants who withdraw later must be erased here too, by hand: delete this folder and export again.
"""
