"""Tables as text: decimal points whatever the locale, n/a for what is missing; CSV by RFC 4180, TSV as BIDS has it."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from .columns import MISSING, Column


def field_text(value: Any) -> str:
    """One value. Numbers in the shortest text that reads back as the same one; whole ones without a point."""
    if value is None or value == "":
        return MISSING
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return str(int(value)) if value.is_integer() and abs(value) < 2**53 else repr(float(value))
    return str(value)


def csv_text(rows: Iterable[Mapping[str, Any]], columns: Sequence[Column]) -> str:
    """RFC 4180: commas, CRLF, quotes around what holds a comma, a quote or a line end."""
    return _text(rows, columns, delimiter=",", lineterminator="\r\n")


def tsv_text(rows: Iterable[Mapping[str, Any]], columns: Sequence[Column]) -> str:
    """Tabs, LF. A tab or a line end within a value becomes a space: readers of TSV go line by line."""
    flat = (
        {name: " ".join(value.split()) if isinstance(value, str) else value for name, value in row.items()}
        for row in rows
    )
    return _text(flat, columns, delimiter="\t", lineterminator="\n")


def _text(rows: Iterable[Mapping[str, Any]], columns: Sequence[Column], **dialect: str) -> str:
    stream = io.StringIO()
    writer = csv.writer(stream, **dialect)
    writer.writerow([column.name for column in columns])
    writer.writerows([field_text(row.get(column.name)) for column in columns] for row in rows)
    return stream.getvalue()
