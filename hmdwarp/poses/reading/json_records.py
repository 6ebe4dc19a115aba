"""Records of JSON files as the rows of a table, to be read like any other trace."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ...errors import TraceError, counted
from ...options.documents import DocumentError, parse_json
from ..assumptions import Defect
from .columns import Made, find_columns, named_matrices, names_rotation, rows_text

_LEAST_RECORDS = 2
_NAMES = ("schema", "columns", "header", "headers", "fields", "names", "keys")
# IWER's frames hold time, position, quaternion, then a list for each input.
_IWER = ("time_ms", "x", "y", "z", "qx", "qy", "qz", "qw")
_BROWSER = ("device", *_IWER)  # a head in a line of session.jsonl, behind the name of its session


def table_of_json(path: Path, raw: bytes) -> Made | None:
    """Return comma-separated rows for JSON lines, or for a document with a list of records.

    Names of nested objects are joined by a dot; three numbers in a list become x, y and z, four of
    a rotation its q0 to q3, a list of lists the cells of a matrix. Records of another kind than the
    poses (a header, a schema, events) are left out; records that are values of an object are poses
    as well, by their keys. None where the bytes are no JSON. Errors: DocumentError, as parse_json;
    TraceError for JSON without records.
    """
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        return None
    document = _parsed(text)
    if frames := _iwer_frames(document):
        return Made("iwer", _text([dict(zip(_IWER, frame, strict=False)) for frame in frames], _IWER), _IWER)
    if heads := list(_browser_heads(document)):
        return Made("browser", rows_text(heads), _BROWSER)
    records = _records(document)
    if document is None:
        return None
    if len(records) < _LEAST_RECORDS:
        keys = ", ".join(list(_flat(document))[:8])
        raise TraceError(f"{path} is JSON without a list or an object of poses: its keys are {keys[:300] or 'none'}")
    rows, defects = _of_poses([_flat(record) for record in records])
    names = tuple(dict.fromkeys(name for row in rows[:100] for name in row))
    named = any(name.strip(".0123456789") for name in names)  # not by places in a list alone
    return Made("json", _text(rows, names), names if named else (), defects)


def _iwer_frames(document: Any) -> list[list[Any]]:
    """Return the frames of a recording of IWER anywhere in a document, [] for any other."""
    if not isinstance(document, dict):
        return []
    schema, frames = document.get("schema"), document.get("frames")
    if not (isinstance(schema, list) and isinstance(frames, list)):
        return next(filter(None, map(_iwer_frames, document.values())), [])
    inputs = all(isinstance(entry, list) and len(entry) == 2 and isinstance(entry[1], dict) for entry in schema)
    poses = [frame[: len(_IWER)] for frame in frames if isinstance(frame, list) and len(frame) >= len(_IWER)]
    numbers = bool(poses) and all(isinstance(value, int | float) for value in poses[0])
    return poses if inputs and numbers and len(poses) >= _LEAST_RECORDS else []


def _browser_heads(document: Any) -> Iterator[list[str]]:
    """Yield the heads of a session.jsonl of `hmdwarp serve --web`, none of any other document."""
    for line in document if isinstance(document, list) else [document]:
        if isinstance(line, dict) and {"session", "delays_ms"} <= set(line) and isinstance(line.get("heads"), list):
            for head in line["heads"]:
                if isinstance(head, list) and len(head) == len(_IWER):
                    yield [str(cell).replace(",", " ").replace("\n", " ") for cell in (line["session"], *head)]


def _text(rows: list[dict[str, Any]], names: tuple[str, ...]) -> bytes:
    return rows_text((str(row.get(name, "")) for name in names) for row in rows)


def _parsed(text: str) -> Any:
    """Return a document, or the list of the records of JSON lines; None for neither."""
    try:
        return parse_json(text)
    except DocumentError as error:
        if error.line is None:  # it is JSON, of a kind that is refused
            raise
    try:
        return [parse_json(line) for line in text.splitlines() if line.strip()]
    except DocumentError:
        return None


def _records(document: Any) -> list[Any]:
    """Return the longest list of objects or of lists in a document, named if it has names."""

    def likelihood(records: list[Any]) -> tuple[bool, int, int]:
        first = _flat(records[-1])  # the first may be a header
        return _has_pose(first), len(records), len(first)

    found = max(_lists(document), key=likelihood, default=[])
    if found and isinstance(found[0], list) and _are_names(found[0]):
        return [dict(zip(found[0], record, strict=False)) for record in found[1:] if isinstance(record, list)]
    return found


def _lists(document: Any) -> Iterator[list[Any]]:
    if isinstance(document, list):
        if len(document) == 1:
            yield from _lists(document[0])
        kinds = [isinstance(item, dict | list) for item in document]
        if kinds and sum(kinds) >= _LEAST_RECORDS and sum(kinds) >= len(kinds) - 1:
            yield [item for item, kind in zip(document, kinds, strict=True) if kind]
    elif isinstance(document, dict):
        names = next((document[key] for key in _NAMES if _are_names(document.get(key))), None)
        for value in document.values():
            rows = value if isinstance(value, list) else []
            if names is not None and rows and all(isinstance(r, list) and len(r) == len(names) for r in rows):
                yield [names, *rows]
            else:
                yield from _lists(value)
        yield from _values_of(document)
        yield from _columns_of(document)


def _values_of(document: dict[str, Any]) -> Iterator[list[Any]]:
    """Yield the values of an object that are poses, each with its key, a time or a number."""
    values = [value if isinstance(value, dict) else {"pose": value} for value in document.values()]
    if len(values) < _LEAST_RECORDS or not all(_has_pose(_flat(value)) for value in (values[0], values[-1])):
        return
    numbers = [(re.findall(r"\d+(?:\.\d+)?", key) or [str(i)])[-1] for i, key in enumerate(document)]
    name = "time" if any("." in number for number in numbers) else "frame"
    yield [{name: number, **value} for number, value in zip(numbers, values, strict=True)]


def _columns_of(document: dict[str, Any]) -> Iterator[list[Any]]:
    """Yield the rows of an object that holds a list for each column, if they are poses."""
    lengths = Counter(len(value) for value in document.values() if isinstance(value, list))
    count = max(lengths, key=lambda n: (lengths[n], n), default=0)
    columns = {key: value for key, value in document.items() if isinstance(value, list) and len(value) == count}
    if count < _LEAST_RECORDS:
        return
    rows = [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
    if _has_pose(_flat(rows[0])):
        yield rows


def _are_names(value: Any) -> bool:
    return isinstance(value, list) and len(value) > 4 and all(isinstance(name, str) for name in value)


def _has_pose(row: dict[str, Any]) -> bool:
    found = find_columns(list(row))
    return found.orientation is not None or found.vector is not None or bool(named_matrices(list(row)))


def _of_poses(rows: list[dict[str, Any]]) -> tuple[list[dict[str, Any]], tuple[Defect, ...]]:
    """Return the records that are like those of poses, and what was left out."""
    kinds = Counter(tuple(row) for row in rows)
    likely = max(
        kinds, key=lambda kind: (kinds[kind] >= _LEAST_RECORDS and _has_pose(dict.fromkeys(kind)), kinds[kind])
    )
    wanted = set(likely)
    same = [2 * len(wanted & set(row)) >= len(wanted) for row in rows]
    if all(same):
        return rows, ()
    first = same.index(False)
    shown = ", ".join(list(rows[first])[:3]) or "nothing"
    count = len(rows) - sum(same)
    what = f"{counted(count, 'record')} of another kind than the poses (the first holds {shown})"
    return [row for row, one in zip(rows, same, strict=True) if one], (
        Defect("record-of-another-kind", what, "left out", count),
    )


def _flat(value: Any, name: str = "") -> dict[str, Any]:
    if isinstance(value, dict):
        parts = [(f"{name}.{key}" if name else str(key), part) for key, part in value.items()]
    elif isinstance(value, list):
        cells = [cell for row in value if isinstance(row, list) for cell in row]
        rows = len(value) in (3, 4) and all(isinstance(row, list) and len(row) in (3, 4) for row in value)
        if rows and not any(isinstance(cell, dict | list) for cell in cells):  # a matrix
            return {f"{name}.{r}.{c}": str(cell) for r, row in enumerate(value) for c, cell in enumerate(row)}
        places: list[Any] = list(range(len(value)))
        if len(value) == 3 and not any(isinstance(part, list) for part in value):
            places = list("xyz")
        elif len(value) == 4 and names_rotation(name):
            places = [f"q{i}" for i in range(4)]
        parts = [(f"{name}.{place}", part) for place, part in zip(places, value, strict=True)]
    else:
        return {name: "" if value is None else str(value).replace(",", " ").replace("\n", " ")}
    return {key: number for one, part in parts for key, number in _flat(part, one).items()}
