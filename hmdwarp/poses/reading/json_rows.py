"""JSON records as the rows of a table, so that they are read like any other trace."""

from __future__ import annotations

import json
from typing import Any

from .columns import names_rotation

_XYZ = ("x", "y", "z")
_LEAST_RECORDS = 2


def table_of_json(raw: bytes) -> bytes | None:
    """Return comma-separated rows below a header for JSON lines, or for a document with a list.

    Names of nested objects are joined by a dot; three numbers in a list become x, y and z, and four
    of a rotation its q0 to q3. None where the bytes are no JSON with records.
    """
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        return None
    records = _records(text)
    if len(records) < _LEAST_RECORDS:
        return None
    rows = [_flat(record) for record in records]
    names = list(dict.fromkeys(name for row in rows[:100] for name in row))
    named = any(name.strip(".0123456789") for name in names)  # not by places in a list alone
    lines = [",".join(names)] if named else []
    lines += [",".join(str(row.get(name, "")) for name in names) for row in rows]
    return "\n".join([*lines, ""]).encode()


def _records(text: str) -> list[Any]:
    try:
        return _longest_list(json.loads(text))
    except ValueError:
        pass
    try:
        return [json.loads(line) for line in text.splitlines() if line.strip()]
    except ValueError:
        return []


def _longest_list(document: Any) -> list[Any]:
    """Return the longest list of objects or of lists anywhere in a document."""
    if isinstance(document, list):
        return document if document and all(isinstance(one, dict | list) for one in document) else []
    if isinstance(document, dict):
        return max(map(_longest_list, document.values()), key=len, default=[])
    return []


def _flat(value: Any, name: str = "") -> dict[str, Any]:
    if isinstance(value, dict):
        parts = [(f"{name}.{key}" if name else str(key), part) for key, part in value.items()]
    elif isinstance(value, list):
        parts = [(one, part) for one, part in zip(_names_in(value, name), value, strict=True)]
    else:
        return {name: "" if value is None else str(value).replace(",", " ").replace("\n", " ")}
    return {key: number for one, part in parts for key, number in _flat(part, one).items()}


def _names_in(values: list[Any], name: str) -> list[str]:
    if len(values) == 3 and not any(isinstance(one, list) for one in values):
        return [f"{name}.{axis}" for axis in _XYZ]
    if len(values) == 4 and names_rotation(name):
        return [f"{name}.q{i}" for i in range(4)]
    return [f"{name}.{i}" for i in range(len(values))]
