"""Tables as CSV (RFC 4180), TSV (as BIDS) and Parquet; decimal points in every locale."""

from __future__ import annotations

import csv
import importlib.util
import io
import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

from ...resources import __version__, import_extra
from .table_columns import FLAG, INTEGER, MISSING, NUMBER, Column


def field_text(value: Any) -> str:
    """Format one value, n/a for a missing one.

    Numbers are the shortest text that reads back as the same one, whole ones without a point.
    """
    if value is None or value == "":
        return MISSING
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return str(int(value)) if value.is_integer() and abs(value) < 2**53 else repr(float(value))
    return str(value)


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
