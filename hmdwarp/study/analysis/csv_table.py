"""Reads a long table of ratings: which column is what, by its name, and the text of each field."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import attrs

from ...errors import InputError
from ...options import RATINGS, text_in
from ...report import raw_text

# Names of the columns for each role; the first name that the table has counts.
ROLES: Mapping[str, tuple[str, ...]] = {
    "participant": (
        *("participant", "participant_id", "ppid", "sub", "subject", "subject_id", "person", "observer", "user"),
        *("vp", "id"),
    ),
    "rating": ("rating", "value", "score", "grade", "response", "answer", "vote", "mos"),
    "condition": ("condition", "cond", "treatment", "stimulus"),
    "part": ("part", "run", "group", "experiment"),
    "place": ("trial", "place", "position", "order", "trial_number"),
    "repeat": ("repeat", "repetition", "rep"),
    "session": ("session", "ses"),
    "previous": ("previous",),
    "scale": ("scale",),
    "item": ("item",),
    "reference": ("reference", "hidden_reference"),
    "origin": ("origin",),
    "status": ("status",),
    "low_is_good": ("low_is_good",),
    "latency_ms": ("latency_ms", "latency", "delay_ms", "delay"),
    "warp": ("warp", "method"),
    "fill": ("fill",),
    "scene": ("scene",),
}
SETTINGS = ("latency_ms", "warp", "fill", "scene")
_FALLBACK = "test"  # number of the test: the condition, where no other column gives it
MISSING = frozenset({"", "n/a", "na", "nan", "null", "none", ".", "-", "?", "missing"})


@attrs.frozen
class Line:
    """One row of the table."""

    number: int  # in the file, from 1 on
    fields: Mapping[str, str]  # texts by role, and by "=" and the column's own name


def lines_of(path: Path, columns: Mapping[str, str]) -> tuple[list[Line], dict[str, str]]:
    """Return all rows by role, and the name of each role's column."""
    text = text_in(path, RATINGS)
    if not text.strip():
        raise InputError(f"{path}: is empty: expected a table of ratings, a header and one row for each rating")
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=_delimiter(text), strict=True)
    lines: list[Line] = []
    try:
        header = [name.strip() for name in next(reader, [])]
        roles = _roles_of(header, columns, str(path))
        for cells in reader:
            fields = [raw_text(cell) for cell in cells]
            if not any(field.strip() for field in fields):
                continue
            if len(fields) != len(header):
                raise InputError(
                    f"{path}:{reader.line_num}: {len(fields)} fields, expected {len(header)} as in the first line"
                )
            # Every column under its own name too, behind a mark that no role has: measures are
            # looked up there.
            own = {f"={name}": field.strip() for name, field in zip(header, fields, strict=True)}
            lines.append(Line(reader.line_num, {role: fields[at].strip() for role, at in roles.items()} | own))
    except csv.Error as error:
        raise InputError(f"{path}:{reader.line_num}: {error}: expected a table with one rating per row") from error
    if not lines:
        raise InputError(f"{path}: has no rows below its header: expected one for each rating")
    return lines, {role: header[place] for role, place in roles.items()}


def _delimiter(text: str) -> str:
    first = text.split("\n", 1)[0]
    return max("\t;,", key=first.count)


def _roles_of(header: Sequence[str], named: Mapping[str, str], path: str) -> dict[str, int]:
    """Return the column of each role. named: role to column name, from the user."""
    plain = [_plain(name) for name in header]
    found: dict[str, int] = {}
    for role, name in named.items():
        if role not in ROLES:
            raise InputError(f"--column {role}={name}: expected one of {', '.join(ROLES)} before the '='")
        if _plain(name) not in plain:
            raise InputError(f"{path}:1: no column '{name}' (--column {role}={name}); there are {', '.join(header)}")
        found[role] = plain.index(_plain(name))
    for role, names in ROLES.items():
        if role not in found:
            place = next((plain.index(name) for name in names if name in plain), None)
            if place is not None and place not in found.values():
                found[role] = place
    if _FALLBACK in plain and "condition" not in found and not {"latency_ms", "warp"} & set(found):
        found["condition"] = plain.index(_FALLBACK)
    _check(found, header, path)
    return found


def _plain(name: str) -> str:
    return re.sub(r"[\s\-]+", "_", name.strip().lower())


def _check(found: Mapping[str, int], header: Sequence[str], path: str) -> None:
    for role in ("participant", "rating"):
        if role not in found:
            known = ", ".join(ROLES[role])
            raise InputError(
                f"{path}:1: no column for the {role} among {', '.join(header)}: "
                f"expected one of {known}; or name it: --column {role}=NAME"
            )
    if "condition" not in found and not set(SETTINGS) & set(found):
        raise InputError(
            f"{path}:1: no column gives the condition: expected 'condition', or latency_ms, warp and fill; "
            "or name it: --column condition=NAME"
        )


def numbers_of(lines: Sequence[Line], path: Path) -> tuple[list[float | None], bool]:
    """Return each line's rating, None where missing, and whether they have decimal commas."""
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
        wanted = "expected a number with a decimal point, or an empty field where it is missing"
        raise InputError(f"{path}:{line.number}: rating '{text}': {wanted}")
    return value


def whole_number(line: Line, role: str, path: Path, default: int) -> int:
    """Return a whole number of the line. Errors: InputError for another text."""
    text = line.fields.get(role, "")
    if text.lower() in MISSING:
        return default
    digits = re.fullmatch(r"(?:\w+-)?(\d{1,9})(?:\.0+)?", text)  # ses-01 as in BIDS, 1.0 as in data frames
    if digits is None:
        raise InputError(f"{path}:{line.number}: {role} '{text}': expected a whole number")
    return int(digits[1])
