"""Ratings from long tables: those that hmdwarp exports, and those of other programs."""

from __future__ import annotations

import csv
import io
import math
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs

from ...errors import InputError
from ...options import RATINGS, text_in
from ...report import counted, raw_text
from ..scales import RATING, Scale, load_scale, scale_names
from .ratings import Rating, Ratings, ScaleInfo, SurveyAnswer

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


_ORIGINS = ("person", "simulated", "pilot")


@attrs.frozen
class SourceOptions:
    """What a table does not say itself."""

    columns: Mapping[str, str] = attrs.field(factory=dict, hash=False)  # role to column name
    scale: str = ""  # a shipped one's name or a file
    low_is_good: bool | None = None  # None where not known
    origin: str = ""  # whose ratings, where there are several; "" for people first


def from_csv(path: Path, options: SourceOptions = SourceOptions()) -> Ratings:  # noqa: B008  (frozen)
    """Read the ratings of a long table, one per row.

    Columns are recognised by their names (ROLES), delimiters are , ; and tab. An empty
    field is a missing rating. Several ratings of one participant of one condition are repeats. A
    decimal comma is read as such where no value has a point.

    Errors: InputError naming the file, the line, what was found and what was expected.
    """
    lines, header = lines_of(path, options.columns)
    lines, origin, notes = _of_one_origin(lines, path, options.origin)
    numbers, comma = numbers_of(lines, path)
    if comma:
        notes.append("Ratings have a decimal comma: 3,25 was read as 3.25.")
    infos, unnamed = _scale_infos(lines, numbers, path, options, notes)
    rows, survey, used = _rows(lines, numbers, infos, unnamed, path, header)
    if not rows:
        raise InputError(f"{path}: holds no ratings: {counted(len(lines), 'row')}, none of them on a rating scale")
    repeated = sum(count > 1 for count in Counter((r.participant, r.part, r.condition, r.scale) for r in rows).values())
    if repeated:
        notes.append(f"A participant rated a condition more than once, {counted(repeated, 'time')}: the mean counts.")
    return Ratings(
        tuple(rows), infos, origin=origin, source=path.name, title=path.stem, survey=tuple(survey), notes=tuple(notes),
        long=_long(rows, used, infos),
    )  # fmt: skip


def _of_one_origin(lines: list[Line], path: Path, wanted: str) -> tuple[list[Line], str, list[str]]:
    there = Counter(line.fields.get("origin") or "person" for line in lines)
    origin = wanted or next((whose for whose in _ORIGINS if there[whose]), next(iter(there)))
    if not there[origin]:
        raise InputError(f"{path}: no ratings of origin '{origin}': there are {', '.join(sorted(there))}")
    notes = (
        [f"These ratings are of origin '{origin}', not of people taking part in the study."]
        if origin != "person"
        else []
    )
    left = ", ".join(f"{counted(count, 'row')} of {name}" for name, count in sorted(there.items()) if name != origin)
    notes += [f"Left out, because origins are never mixed: {left}."] if left else []
    return [line for line in lines if (line.fields.get("origin") or "person") == origin], origin, notes


def _scale_infos(
    lines: Sequence[Line], numbers: Sequence[float | None], path: Path, options: SourceOptions, notes: list[str]
) -> tuple[dict[str, ScaleInfo], str]:
    """Return each scale by the name that rows have, and the scale of rows without a name."""
    found, unnamed = {}, ""
    for name in dict.fromkeys(line.fields.get("scale", "") for line in lines):
        own = [
            (line, value) for line, value in zip(lines, numbers, strict=True) if line.fields.get("scale", "") == name
        ]
        info = _scale_info(name, own, path, options, notes)
        if info is not None:
            found[name or info.name] = info
            unnamed = unnamed if name else info.name
    return found, unnamed


def _scale_info(
    name: str, own: list[tuple[Line, float | None]], path: Path, options: SourceOptions, notes: list[str]
) -> ScaleInfo | None:
    """Return a scale by its name, else as user or table describe it; None for a survey."""
    known = options.scale or (name if name in scale_names() else "")
    if known:
        scale = load_scale(known)
        if scale.kind != RATING and name:
            return None
        _check_range(own, scale, path)
        return ScaleInfo.of(scale)
    values = [value for _, value in own if value is not None]
    low = _low_is_good(own, path) if options.low_is_good is None else options.low_is_good
    if low is not None:
        return ScaleInfo(name or "rating", name or "Rating", low)
    grade = load_scale("grade")
    # A value above 5 cannot be one of the five ACR categories; whole numbers from 1 to 5 fit either
    # direction.
    if values and min(values) >= grade.least and 5 < max(values) <= grade.most:
        notes.append(
            f"The table does not give the direction of its ratings. All lie in {grade.least:g} to {grade.most:g}, "
            "so they "
            "are read on the scale 'grade', where 1 is the best. Otherwise use --scale NAME, --low-is-good or "
            "--high-is-good."
        )
        return ScaleInfo.of(grade)
    raise InputError(
        f"{path}: the direction of the ratings is unknown: use --low-is-good, --high-is-good, or --scale with one of "
        f"{', '.join(scale_names())}"
    )


def _low_is_good(own: list[tuple[Line, float | None]], path: Path) -> bool | None:
    """Return what the table says of the scale's direction, None where it says nothing."""
    words = {"true": True, "1": True, "false": False, "0": False}
    stated = [(words[text], line) for line, _ in own if (text := line.fields.get("low_is_good", "").lower()) in words]
    for low, line in stated:
        if low != stated[0][0]:
            first, text = stated[0][1], line.fields["low_is_good"]
            raise InputError(
                f"{path}:{line.number}: low_is_good '{text}', and '{first.fields['low_is_good']}' in line "
                f"{first.number}: expected one direction for all ratings on a scale"
            )
    return stated[0][0] if stated else None


def _check_range(own: list[tuple[Line, float | None]], scale: Scale, path: Path) -> None:
    for line, value in own:
        if value is not None and not scale.least <= value <= scale.most:
            limits = f"the scale '{scale.name}' goes from {scale.least:g} to {scale.most:g}"
            raise InputError(f"{path}:{line.number}: rating {value:g}: {limits}")


def _rows(
    lines: Sequence[Line],
    numbers: Sequence[float | None],
    infos: Mapping[str, ScaleInfo],
    unnamed: str,
    path: Path,
    header: Mapping[str, str],
) -> tuple[list[Rating], list[SurveyAnswer], list[Line]]:
    """Return the ratings, the survey answers, and the lines of the ratings."""
    rows: list[Rating] = []
    survey: list[SurveyAnswer] = []
    used: list[Line] = []
    for line, value in zip(lines, numbers, strict=True):
        fields = line.fields
        if fields["participant"].lower() in MISSING:
            raise InputError(f"{path}:{line.number}: no participant: every rating needs one")
        place = whole_number(line, "place", path, 0)
        part = _part(fields.get("part", ""), header.get("part", ""))
        session = whole_number(line, "session", path, 1)
        scale = fields.get("scale", "") or unnamed
        if scale not in infos:
            phase, item = "trial" if place else fields.get("=phase", ""), fields.get("item", "")
            survey.append(SurveyAnswer(fields["participant"], part, session, phase, place, scale, item, value))
            continue
        condition, settings = _condition(line, path)
        if not condition:
            continue  # the practice is not scored
        used.append(line)
        rows.append(
            Rating(
                participant=fields["participant"],
                part=part,
                condition=condition,
                scale=scale,
                value=value,
                why_missing="" if value is not None else _why(line),
                reference=fields.get("reference", "").lower() in ("true", "1", "yes"),
                repeat=whole_number(line, "repeat", path, 1),
                place=place,
                previous="" if fields.get("previous", "").lower() in MISSING else fields["previous"],
                session=session,
                settings=settings,
            )
        )
    return _with_previous(rows), survey, used


def _why(line: Line) -> str:
    why = line.fields.get("=why_missing", "")
    if why.lower() not in MISSING:
        return why
    status = line.fields.get("status", "")
    return f"empty in line {line.number}" + (
        f"; the session's status is '{status}'" if status not in ("", "complete") else ""
    )


def _part(text: str, column: str) -> str:
    """Return "run 1" where the column "run" holds just 1."""
    return f"{column} {text}" if re.fullmatch(r"\d+", text) else text


def _condition(line: Line, path: Path) -> tuple[str, dict[str, Any]]:
    fields = line.fields
    settings: dict[str, Any] = {
        name: fields[name] for name in SETTINGS if fields.get(name, "").lower() not in MISSING - {"none"}
    }
    if "latency_ms" in settings:
        try:
            settings["latency_ms"] = float(settings["latency_ms"])
        except ValueError:
            raise InputError(
                f"{path}:{line.number}: latency '{settings['latency_ms']}': expected milliseconds, like 200"
            ) from None
    if fields.get("condition", "").lower() not in MISSING - {"none"}:
        return fields["condition"], settings
    return ("" if "condition" in fields else name_of(settings)), settings


def name_of(settings: Mapping[str, Any]) -> str:
    """Name a condition by its settings, like "forward + interpolate, 200 ms"."""
    passes = [str(settings[name]) for name in ("warp", "fill") if settings.get(name)]
    if len(passes) > 1 and passes[1] == "none":
        passes.pop()
    latency = [f"{settings['latency_ms']:g} ms"] if "latency_ms" in settings else []
    scene = [str(settings["scene"])] if settings.get("scene") else []
    return ", ".join([*([" + ".join(passes)] if passes else []), *latency, *scene])


def _with_previous(rows: list[Rating]) -> list[Rating]:
    """Add the condition before each, from the places of the trials, where the table lacks it."""
    at = {(r.participant, r.part, r.session, r.place): r.condition for r in rows if r.place}

    def before(row: Rating) -> str:
        return row.previous or at.get((row.participant, row.part, row.session, row.place - 1), "")

    return [attrs.evolve(row, previous=before(row)) if row.place else row for row in rows]


def _long(rows: Sequence[Rating], used: Sequence[Line], infos: Mapping[str, ScaleInfo]) -> tuple[dict[str, Any], ...]:
    """Return the rows of ratings with all columns of the table, as export.long_rows does.

    Empty where the table has no measures.
    """
    if not any(name.startswith(("=actual_", "=measured_")) for line in used[:1] for name in line.fields):
        return ()
    return tuple(
        {name[1:]: _typed(text) for name, text in line.fields.items() if name.startswith("=")}
        | {name: getattr(row, name) for name in ("participant", "part", "condition", "scale", "value", "session")}
        | {"low_is_good": infos[row.scale].low_is_good, "trial": row.place}
        for row, line in zip(rows, used, strict=True)
    )


def _typed(text: str) -> Any:
    if text.lower() in MISSING - {"none"}:
        return None
    try:
        return float(text)
    except ValueError:
        return text
