"""Columns of the exported tables, and the tables as CSV, TSV and Parquet."""

from __future__ import annotations

import csv
import importlib.util
import io
import itertools
import json
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import attrs

from ...metrics import metrics_in_order
from ...report import inert_text
from ...resources import __version__, import_extra
from ..actual import COUNTS, FLAGS, NUMBERS, TEXTS
from ..design import DISPLAY, KINDS
from ..scales import KINDS as SCALE_KINDS
from ..store import COMPLETE, DECLINED, ORIGINS, STATUSES, UNCONSENTED

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


_WHO = (
    Column("study", TEXT, "Name of the study"),
    Column("participant", TEXT, "Random word for the participant, which does not identify the person"),
    Column("session", INTEGER, "Which session of the participant, from 1 on"),
    Column("part", TEXT, "Part of the study"),
    Column("origin", TEXT, "Who answered", levels=dict(zip(ORIGINS, (
        "a participant", "a pilot, who tried the study out", "a program"), strict=True))),
    Column("status", TEXT, "How the session ended", levels=dict(zip(STATUSES, (
        "it was running", "it may be resumed", "complete",
        "ended by the participant or the experimenter, without a reason", "ended by the stop rule for sickness",
        "the consent was refused: in no table", "it ended before the consent was given: in no table",
    ), strict=True))),
    Column("order", INTEGER, "Which of the part's orders of conditions, from 0 on"),
)  # fmt: skip
_WHAT = (
    Column("trial", INTEGER, "Place of the trial in the session, from 1 on; 0 is the practice"),
    Column("block", INTEGER, "Trials between two planned breaks, from 1 on; 0 is the practice"),
    Column("repeat", INTEGER, "Which time the condition was shown in this session, from 1 on"),
    Column("condition", TEXT, "Name of the condition"),
    Column("reference", FLAG, "Whether it is the hidden reference"),
    Column("previous", TEXT, "Condition of the trial before, n/a for the first"),
)
# In every table, whatever a study sets; in the units of the live run.
SETTINGS = ("latency_ms", "warp", "fill", "scene", "effects", "lens")
_SETTING_TEXTS = {
    "latency_ms": "From drawing a frame to showing it, as configured",
    "warp": "Warp of a late frame to the newest pose",
    "fill": "Fill of the holes",
    "scene": "Scene shown",
    "effects": "Effects of the scene that are carried in layers",
    "lens": "Lens correction",
}
_SHOWN = (
    Column("scale", TEXT, "Scale of the question"),
    Column("item", TEXT, "Question of the scale"),
    Column("value", NUMBER, "The answer"),
    Column("low_is_good", FLAG, "Direction of the scale: whether a low value is a good one"),
    Column("why_missing", TEXT, "Why there is no value, n/a where there is one", levels={
        CANNOT_SAY: "the participant could not say",
        NOT_ASKED: "the session ended without the question",
        NOT_ALL: "answers that the score needs are missing",
        **{f"session {status}": "the session ended before the answer" for status in STATUSES
           if status not in (COMPLETE, DECLINED, UNCONSENTED)},
    }),
    Column("seconds_to_answer", NUMBER, "From the question to the confirmed answer", "s"),
    Column("revision", INTEGER, "More than 1 where the question was repeated; the last one counts"),
    Column("presentation", INTEGER, "Showing that the answer is about; more than 1 where the trial was repeated"),
    Column("answered_by", TEXT, "Who entered the answer"),
)  # fmt: skip
_PHASE = (
    Column("phase", TEXT, "When the question came", levels=dict(zip(PHASES, (
        "before the first trial", "after the practice", "after a trial", "after the last trial"), strict=True))),
    Column("kind", TEXT, "Kind of the scale", levels=dict(zip((*SCALE_KINDS, "score"), (
        "a rating of what was shown", "sickness", "an answer to one question of several",
        "which of two was preferred", "a score of a questionnaire"), strict=True))),
    Column("text", TEXT, "The answer in words: the choice, or what was typed; n/a for the answers of a scale"),
)  # fmt: skip

_UNITS = (("_ms", "ms"), ("_hz", "Hz"), ("_deg_s", "deg/s"), ("_m_s", "m/s"), ("_s", "s"), ("_db", "dB"))
_ACTUAL_TEXTS = {
    "seconds": ("From the first picture to the last", "s"),
    "pictures": ("Pictures shown", ""),
    "rate_hz": ("Pictures per second, measured", "Hz"),
    "latency_ms": ("Age of the frame when it was seen", "ms"),
    "period_ms": ("Between two pictures", "ms"),
    "missed": ("Refreshes of the display without a new picture", ""),
    "missed_share": ("Share of refreshes without a new picture", ""),
    "over_budget_share": ("Share of pictures that took longer than a refresh", ""),
    "hole_share": ("Share of pixels without colour after the warp and before the fill", ""),
    "pose_age_ms": ("From reading the head pose to submitting the picture", "ms"),
    "passes_ms": ("Time of the passes, both eyes together", "ms"),
    "angular_speed_deg_s": ("Angular speed of the head", "deg/s"),
    "linear_speed_m_s": ("Speed of the head", "m/s"),
    "lost_s": ("Time without a display", "s"),
    "tracking_lost_share": ("Share of pictures for a head pose held because tracking was lost", ""),
    "onset_s": ("From the start of the session to the first picture", "s"),
    "head_turn_deg": ("Largest angle of the head from its first direction", "deg"),
    "head_shift_m": ("Largest distance of the head from its first place", "m"),
    "task_targets": ("Targets that there were to find", ""),
    "task_found": ("Targets found and selected", ""),
    "task_misses": ("Selections without a target there", ""),
    "task_target_s": ("Time for each target found: until the last of all, or the whole trial", "s"),
    "task_turned_deg": ("Path of the head until the last target was found: the sum of its turns", "deg"),
    "head_still": ("Whether the head hardly moved, so that little could be seen of the latency", ""),
}
_OF = {"_median": "median", "_p95": "95th percentile", "_sd": "standard deviation", "_mean": "mean"}
_TEXTS = {
    "gpu": "GPU",
    "gl": "Version of OpenGL",
    "hmdwarp": "Version of hmdwarp",
    "commit": "Commit of hmdwarp",
    "options": "Digest of the options",
    "numpy": "Version of NumPy",
    "moderngl": "Version of moderngl",
    "size": "Pixels of one eye",
    "source": "Display",
    "ended_by": "What ended the trial: its time, the last of its targets, or who said that the participant is done",
    "task_times_s": "Times of the selected targets in their order, seconds since the first picture",
    "headset": "Headset; where a window or trace leads the head, only its optics were emulated",
}


def _actual(name: str) -> Column:
    if name in TEXTS:
        return Column(f"actual_{name}", TEXT, f"As it was shown: {_TEXTS.get(name, name)}")
    stem, how = next(
        ((name.removesuffix(end), f", {word}") for end, word in _OF.items() if name.endswith(end)), (name, "")
    )
    text, unit = _ACTUAL_TEXTS.get(
        stem, (stem.replace("_", " "), next((u for end, u in _UNITS if stem.endswith(end)), ""))
    )
    kind = FLAG if name in FLAGS else INTEGER if name in COUNTS else NUMBER
    return Column(f"actual_{name}", kind, f"As it was shown: {text}{how}", unit)


ACTUAL_COLUMNS = tuple(_actual(name) for name in (*NUMBERS, *FLAGS, *TEXTS))
MEASURED_COLUMNS = (
    *(Column(f"measured_{m.name}", NUMBER, f"Afterwards, mean of the measured pictures: {m.description}", m.unit)
      for m in metrics_in_order()),
    Column("measured_refreshes", INTEGER, "How many refreshes were measured afterwards, both eyes of each"),
    Column("measured_every", INTEGER, "Every n-th refresh was measured; do not compare figures of different n"),
    Column("measured_size", TEXT, "Pixels of one eye in the measured pictures; do not compare different sizes"),
)  # fmt: skip
# Of studies that were rated by `study measure --jod`.
RATED_COLUMNS = (
    Column("measured_jod", NUMBER, "Afterwards, by ColorVideoVDP: how people would rate the pictures, 10 for the truth",
           "JOD"),
    Column("measured_jod_s", NUMBER, "Length of the clips that ColorVideoVDP rated", "s"),
)  # fmt: skip
_SETTING_COLUMNS = tuple(
    Column(name, NUMBER if name == "latency_ms" else TEXT, _SETTING_TEXTS[name], "ms" if name == "latency_ms" else "")
    for name in SETTINGS
)
COLUMNS = (*_WHO, *_WHAT, *_SETTING_COLUMNS, *_SHOWN, *ACTUAL_COLUMNS, *MEASURED_COLUMNS)
LONG_COLUMNS = tuple(column.name for column in COLUMNS)

# Settings besides SETTINGS: columns of studies that use them.
OTHER_SETTINGS = tuple(name for name in KINDS if name not in (*DISPLAY, *SETTINGS, "latency"))
# Only in tables of a store that was merged.
_SITE = Column("site", TEXT, "Site that the session comes from")
_BY_NAME = {column.name: column for column in (*COLUMNS, *RATED_COLUMNS, *_PHASE, _SITE)}


def column_of(name: str) -> Column:
    """Return the column of that name, by default a setting of a study."""
    if name in _BY_NAME:
        return _BY_NAME[name]
    kind = {"a number": NUMBER, "a whole number": INTEGER, "true or false": FLAG}.get(KINDS.get(name, ""), TEXT)
    return Column(name, kind, f"Setting of the condition: --{name.replace('_', '-')} of hmdwarp live")


def columns_for(rows: Sequence[Mapping[str, Any]], more: Sequence[str] = ()) -> tuple[Column, ...]:
    """Return COLUMNS, with the rows' other settings after SETTINGS, and `more` before the scale.

    The rows of a merged store have their site first; RATED_COLUMNS are the last where a row has
    them.
    """
    site, *others = ([name] if any(name in row for row in rows) else [] for name in (_SITE.name, *OTHER_SETTINGS))
    rated = [column.name for column in RATED_COLUMNS if any(row.get(column.name) is not None for row in rows)]
    before, after = LONG_COLUMNS.index(SETTINGS[-1]) + 1, LONG_COLUMNS
    names = (*site, *after[:before], *itertools.chain(*others), *more, *after[before:], *rated)
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
