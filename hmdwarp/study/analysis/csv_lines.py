"""The lines of a long table, before anybody asks what they mean."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import attrs

from ...errors import InputError
from .columns import MISSING, roles_of

_MOST_BYTES = 200_000_000


@attrs.frozen
class Line:
    """number: in the file, from 1 on. fields: texts by role, and by "=" and the column's own name."""

    number: int
    fields: Mapping[str, str]


def lines_of(path: Path, columns: Mapping[str, str]) -> tuple[list[Line], dict[str, str]]:
    """All rows by role, and what the column of each role is called."""
    text = _text(path)
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=_delimiter(text), strict=True)
    lines: list[Line] = []
    try:
        header = [name.strip() for name in next(reader, [])]
        roles = roles_of(header, columns, str(path))
        for fields in reader:
            if not any(field.strip() for field in fields):
                continue
            if len(fields) != len(header):
                raise InputError(
                    f"{path}:{reader.line_num}: {len(fields)} fields, wanted {len(header)} as in the first line"
                )
            lines.append(
                Line(
                    reader.line_num,
                    {role: fields[place].strip() for role, place in roles.items()} | _rest(header, fields),
                )
            )
    except csv.Error as error:
        raise InputError(f"{path}:{reader.line_num}: {error}: wanted a table with one rating in a row") from error
    if not lines:
        raise InputError(f"{path}: has no rows below its header: wanted one for each rating")
    return lines, {role: header[place] for role, place in roles.items()}


def _rest(header: Sequence[str], fields: Sequence[str]) -> dict[str, str]:
    """Every column under its own name too, behind a mark that no role has: what was measured is looked up there."""
    return {f"={name}": field.strip() for name, field in zip(header, fields, strict=True)}


def _text(path: Path) -> str:
    try:
        if path.stat().st_size > _MOST_BYTES:
            raise InputError(
                f"{path}: {path.stat().st_size} bytes: wanted a table of ratings, of at most {_MOST_BYTES}"
            )
        return path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: byte {error.start} is no UTF-8: save the table as UTF-8") from error
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}: wanted a table of ratings (.csv, .tsv)") from error


def _delimiter(text: str) -> str:
    first = text.split("\n", 1)[0]
    return max("\t;,", key=first.count)


def numbers_of(lines: Sequence[Line], path: Path) -> tuple[list[float | None], bool]:
    """The rating of each line, None where missing, and whether they have decimal commas."""
    texts = [line.fields["rating"] for line in lines]
    comma = any(re.fullmatch(r"[+-]?\d+,\d+", text) for text in texts) and not any(
        "." in text for text in texts if text not in MISSING
    )
    return [
        _number(text.replace(",", ".") if comma else text, line, path) for text, line in zip(texts, lines, strict=True)
    ], comma


def _number(text: str, line: Line, path: Path) -> float | None:
    if text.lower() in MISSING:
        return None
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value) or "_" in text:
        wanted = "wanted a number with a decimal point, or an empty field where it is missing"
        raise InputError(f"{path}:{line.number}: rating '{text}': {wanted}")
    return value


def whole(line: Line, role: str, path: Path, default: int) -> int:
    """A column of whole numbers. Errors: InputError for another text."""
    text = line.fields.get(role, "")
    if text.lower() in MISSING:
        return default
    digits = re.fullmatch(r"(?:\w+-)?(\d{1,9})(?:\.0+)?", text)  # ses-01 as BIDS has it, 1.0 as data frames do
    if digits is None:
        raise InputError(f"{path}:{line.number}: {role} '{text}': wanted a whole number")
    return int(digits[1])
