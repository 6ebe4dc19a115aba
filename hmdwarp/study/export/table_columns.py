"""Columns of the exported tables, and the tables as CSV, TSV and Parquet."""

from __future__ import annotations

import csv
import importlib.util
import io
import json
import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import attrs

from ...metrics import metrics_in_order
from ...report import inert_text
from ...resources import __version__, import_extra
from ...scenes import ACTIONS
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
