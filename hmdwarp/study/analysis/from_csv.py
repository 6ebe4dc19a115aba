"""Ratings from long tables: our own exports, and those of others."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs

from ...errors import InputError
from ...report import counted
from ..scales import RATING, load_scale, scale_names
from .columns import MISSING, SETTINGS
from .csv_lines import Line, lines_of, numbers_of, whole
from .ratings import Felt, Measure, Rating, Ratings

_ORIGINS = ("person", "simulated", "pilot")


@attrs.frozen
class Given:
    """What a table does not say itself. columns: role to column name. scale: a shipped one's name or a file. low_is_good: None where not
    told. origin: whose ratings, where the table has several."""

    columns: Mapping[str, str] = attrs.field(factory=dict, hash=False)
    scale: str = ""
    low_is_good: bool | None = None
    origin: str = ""


def from_csv(path: Path, given: Given = Given()) -> Ratings:  # noqa: B008  (frozen)
    """The ratings in a long table, one row each; columns are found by their names (study/analysis/columns.py), delimiters , ; and tab.

    An empty field is a missing rating. Ratings of one participant of one condition count as repeats. A decimal comma is understood where no
    value has a point. Errors: InputError naming the file, the line, what was found and what was wanted.
    """
    lines, header = lines_of(path, given.columns)
    lines, origin, notes = _of_one_origin(lines, path, given.origin)
    numbers, comma = numbers_of(lines, path)
    if comma:
        notes.append("Ratings have a decimal comma: 3,25 was read as 3.25.")
    measures, unnamed = _measures(lines, numbers, path, given, notes)
    rows, felt, used = _rows(lines, numbers, measures, unnamed, path, header)
    if not rows:
        raise InputError(f"{path}: holds no ratings: {counted(len(lines), 'row')}, none of them on a rating scale")
    repeated = sum(count > 1 for count in Counter((r.participant, r.part, r.condition, r.scale) for r in rows).values())
    if repeated:
        notes.append(f"{repeated} times a participant rated a condition more than once: the mean counts.")
    return Ratings(
        tuple(rows), measures, origin=origin, source=path.name, title=path.stem, felt=tuple(felt), notes=tuple(notes),
        long=_long(rows, used, measures),
    )  # fmt: skip


def _of_one_origin(lines: list[Line], path: Path, wanted: str) -> tuple[list[Line], str, list[str]]:
    there = Counter(line.fields.get("origin") or "person" for line in lines)
    origin = wanted or next((one for one in _ORIGINS if there[one]), next(iter(there)))
    if not there[origin]:
        raise InputError(f"{path}: no ratings of origin '{origin}': there are {', '.join(sorted(there))}")
    notes = (
        [f"These ratings are of origin '{origin}', not of people taking part in the study."]
        if origin != "person"
        else []
    )
    left = ", ".join(f"{count} of {name}" for name, count in sorted(there.items()) if name != origin)
    notes += [f"Left out, as they never count together: {left} rows."] if left else []
    return [line for line in lines if (line.fields.get("origin") or "person") == origin], origin, notes


def _measures(
    lines: Sequence[Line], numbers: Sequence[float | None], path: Path, given: Given, notes: list[str]
) -> tuple[dict[str, Measure], str]:
    """What each scale is: of its name where it is known, else as the user or the table says. And which one rows without a name are on."""
    names = dict.fromkeys(line.fields.get("scale", "") for line in lines)
    found, unnamed = {}, ""
    for name in names:
        own = [
            (line, value) for line, value in zip(lines, numbers, strict=True) if line.fields.get("scale", "") == name
        ]
        measure = _measure(name, own, path, given, notes)
        if measure is not None:
            found[name or measure.name] = measure
            unnamed = unnamed if name else measure.name
    return found, unnamed


def _measure(
    name: str, own: list[tuple[Line, float | None]], path: Path, given: Given, notes: list[str]
) -> Measure | None:
    known = given.scale or (name if name in scale_names() else "")
    if known:
        scale = load_scale(known)
        if scale.kind != RATING and name:
            return None  # sickness and questionnaires are told apart from ratings
        measure = Measure.of(scale)
        _check_range(own, measure, path)
        return measure
    values = [value for _, value in own if value is not None]
    said = own[0][0].fields.get("low_is_good", "").lower()
    low = (
        given.low_is_good
        if given.low_is_good is not None
        else {"true": True, "1": True, "false": False, "0": False}.get(said)
    )
    if low is not None:
        return Measure(name or "rating", name or "Rating", low)
    grade = load_scale("grade")
    # A value above 5 cannot be one of the five ACR categories; whole numbers from 1 to 5 could be either way round.
    if values and min(values) >= grade.least and 5 < max(values) <= grade.most:
        notes.append(
            f"The table does not say which way its ratings go: all lie in {grade.least:g} to {grade.most:g}, so they are taken for the "
            "scale 'grade', where 1 is the best. If that is wrong, say --scale NAME, --low-is-good or --high-is-good."
        )
        return Measure.of(grade)
    raise InputError(
        f"{path}: nothing says whether a high rating is good or bad: say --low-is-good, --high-is-good, or --scale with one of "
        f"{', '.join(scale_names())}"
    )


def _check_range(own: list[tuple[Line, float | None]], measure: Measure, path: Path) -> None:
    for line, value in own:
        if value is not None and not measure.least <= value <= measure.most:
            scale = f"the scale '{measure.name}' goes from {measure.least:g} to {measure.most:g}"
            raise InputError(f"{path}:{line.number}: rating {value:g}: {scale}")


def _rows(
    lines: Sequence[Line],
    numbers: Sequence[float | None],
    measures: Mapping[str, Measure],
    unnamed: str,
    path: Path,
    header: Mapping[str, str],
) -> tuple[list[Rating], list[Felt], list[Line]]:
    """Ratings, what else was answered, and the lines that the ratings stand in."""
    rows: list[Rating] = []
    felt: list[Felt] = []
    used: list[Line] = []
    for line, value in zip(lines, numbers, strict=True):
        fields = line.fields
        if fields["participant"].lower() in MISSING:
            raise InputError(f"{path}:{line.number}: no participant: every rating needs to say whose it is")
        place = whole(line, "place", path, 0)
        part = _part(fields.get("part", ""), header.get("part", ""))
        session = whole(line, "session", path, 1)
        scale = fields.get("scale", "") or unnamed
        if scale not in measures:
            phase = "trial" if place else fields.get("=phase", "")
            felt.append(Felt(fields["participant"], part, session, phase, place, scale, fields.get("item", ""), value))
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
                repeat=whole(line, "repeat", path, 1),
                place=place,
                previous="" if fields.get("previous", "").lower() in MISSING else fields["previous"],
                session=session,
                settings=settings,
            )
        )
    return _with_previous(rows), felt, used


def _why(line: Line) -> str:
    told = line.fields.get("=why_missing", "")
    if told.lower() not in MISSING:
        return told
    status = line.fields.get("status", "")
    return f"empty in line {line.number}" + (
        f"; the session's status is '{status}'" if status not in ("", "complete") else ""
    )


def _part(text: str, column: str) -> str:
    """As "run 1" where the column says just 1."""
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
                f"{path}:{line.number}: latency '{settings['latency_ms']}': wanted milliseconds, like 200"
            ) from None
    if fields.get("condition", "").lower() not in MISSING - {"none"}:
        return fields["condition"], settings
    return ("" if "condition" in fields else name_of(settings)), settings


def name_of(settings: Mapping[str, Any]) -> str:
    """What a condition is called that has no name: "forward + interpolate, 200 ms"."""
    passes = [str(settings[name]) for name in ("warp", "fill") if settings.get(name)]
    if len(passes) > 1 and passes[1] == "none":
        passes.pop()
    latency = [f"{settings['latency_ms']:g} ms"] if "latency_ms" in settings else []
    scene = [str(settings["scene"])] if settings.get("scene") else []
    return ", ".join([*([" + ".join(passes)] if passes else []), *latency, *scene])


def _with_previous(rows: list[Rating]) -> list[Rating]:
    """The condition before each, where the table has the places of the trials and does not say it itself."""
    at = {(r.participant, r.part, r.session, r.place): r.condition for r in rows if r.place}

    def before(row: Rating) -> str:
        return row.previous or at.get((row.participant, row.part, row.session, row.place - 1), "")

    return [attrs.evolve(row, previous=before(row)) if row.place else row for row in rows]


def _long(rows: Sequence[Rating], used: Sequence[Line], measures: Mapping[str, Measure]) -> tuple[dict[str, Any], ...]:
    """The rows of ratings with all columns of the table, as export.long_rows has them: for what was measured while pictures were shown."""
    if not any(name.startswith(("=actual_", "=measured_")) for line in used[:1] for name in line.fields):
        return ()
    return tuple(
        {name[1:]: _typed(text) for name, text in line.fields.items() if name.startswith("=")}
        | {name: getattr(row, name) for name in ("participant", "part", "condition", "scale", "value", "session")}
        | {"low_is_good": measures[row.scale].low_is_good, "trial": row.place}
        for row, line in zip(rows, used, strict=True)
    )


def _typed(text: str) -> Any:
    if text.lower() in MISSING - {"none"}:
        return None
    try:
        return float(text)
    except ValueError:
        return text
