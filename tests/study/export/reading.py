"""The export's tables read back, by another reader than the program's own (analysis.from_csv),
which knows no types of columns.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from typing import Any

from hmdwarp.study.export.export_rows import FLAG, INTEGER, MISSING, NUMBER, Column

_READ = {"true": True, "false": False}


def read_table(text: str, columns: Sequence[Column], delimiter: str = ",") -> list[dict[str, Any]]:
    """Back to rows, by the types of the columns; None for n/a.

    Errors: KeyError for a column that is not among them, ValueError.
    """
    types = {column.name: column.type for column in columns}
    reader = csv.DictReader(io.StringIO(text, newline=""), delimiter=delimiter)
    return [{name: _value(types[name], value) for name, value in row.items()} for row in reader]


def _value(type_: str, text: str) -> Any:
    if text == MISSING:
        return None
    if type_ == FLAG:
        return _READ[text]
    if type_ not in (NUMBER, INTEGER):
        begin = text[1:].lstrip()
        while begin.startswith("'"):
            begin = begin[1:].lstrip()
        blank = {*text[1 : len(text) - len(begin)]} & {"\t", "\r", "\n"}
        return text[1:] if text.startswith("'") and (blank or begin[:1] in tuple("=+-@＝＋－＠")) else text
    return {NUMBER: float, INTEGER: int}[type_](text)
