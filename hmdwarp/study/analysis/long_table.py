"""Ratings of one origin as one long table, from a study's store or from anybody's file.

A row is one planned rating; its value is NaN where it is missing, and why_missing says why. Answers
about pairs, to questionnaires and sickness scales, and the sessions are tables of their own.
"""

from __future__ import annotations

import csv
import functools
import io
import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs
import pandas as pd

from ...base import RATINGS, InputError, text_in
from ...report import counted, listed, raw_text
from .. import store as stored
from ..design import ONLY_PART, SHIPPED, Design, Family, every_scale, load_design
from ..export import write
from ..export.write import answer_row, no_sessions, of_origin, sessions_of, without_consent
from ..scales import PREFERENCE, RATING, Scale, load_scale, scale_names
from ..store import DATABASE, PERSON, PILOT, Contents, Store

# Columns that each table has, with what stands where a source says nothing.
COLUMNS = {
    "participant": "", "part": "", "condition": "", "scale": "", "value": math.nan, "why_missing": "",
    "reference": False, "repeat": 1, "place": 0, "previous": "", "session": 1,
}  # fmt: skip
_PAIRS = {
    "participant": "", "part": "", "scale": "", "first": "", "second": "", "answer": math.nan, "allows_ties": False,
    "reference": "", "place": 0,
}  # fmt: skip
_SURVEY = {"participant": "", "part": "", "session": 1, "phase": "", "trial": 0, "scale": "", "item": "", "value": 0.0}
_SESSIONS = {"participant": "", "part": "", "session": 1, "status": "", "why": "", "rated": 0, "planned": 0}
SETTINGS = ("latency_ms", "warp", "fill", "scene")
# Why a rating is missing, as exported tables say it, in words.
_WHY = {
    write.CANNOT_SAY: "the participant could not say",
    write.NOT_ASKED: "not answered",
    f"session {stored.SICK}": "the stop rule for sickness ended the session before",
    f"session {stored.STOPPED}": "the session was stopped before",
    f"session {stored.INTERRUPTED}": "the session was interrupted and not resumed",
    f"session {stored.RUNNING}": "the session is still running, or its program died",
}


def frame(rows: Iterable[Mapping[str, Any]] | pd.DataFrame, columns: Mapping[str, Any] = COLUMNS) -> pd.DataFrame:
    """Return a table of rows that has these columns."""
    found = pd.DataFrame(rows if isinstance(rows, pd.DataFrame) else list(rows))
    for name, default in columns.items():
        known = found[name] if name in found else pd.Series(default, found.index)
        found[name] = known.where(known.notna(), default).astype(type(default))
    return found


def _table(columns: Mapping[str, Any]) -> Any:
    return attrs.field(factory=tuple, converter=lambda rows: frame(rows, columns))


@attrs.frozen
class ScaleInfo:
    """Direction, range and unit of a scale of ratings."""

    name: str
    title: str
    low_is_good: bool
    least: float | None = None  # None where not known, as `most`
    most: float | None = None
    unit: str = "points"
    mean_name: str = "mean"  # of a condition's ratings: "DMOS" where they are relative to a reference

    @classmethod
    def of(cls, scale: Scale) -> ScaleInfo:
        unit, mean = "grades" if scale.name == "grade" else "points", "DMOS" if scale.beside_reference else "mean"
        return cls(scale.name, scale.title, scale.low_is_good, scale.least, scale.most, unit, mean)

    @property
    def sign(self) -> int:
        """Factor that turns "baseline minus condition" into "the condition is better"."""
        return 1 if self.low_is_good else -1


@attrs.frozen(eq=False, slots=False)
class Ratings:
    """All ratings of one origin: people, pilots and simulated participants are never mixed."""

    rows: pd.DataFrame = attrs.field(converter=frame)  # COLUMNS, SETTINGS and measures, as far as known
    scale_info: Mapping[str, ScaleInfo]
    families: tuple[Family, ...] = ()  # planned comparisons
    planned: Mapping[str, tuple[str, ...]] = attrs.field(factory=dict)  # conditions by part, as planned
    origin: str = PERSON
    source: str = ""  # for messages
    title: str = ""
    sessions: pd.DataFrame = _table(_SESSIONS)
    survey: pd.DataFrame = _table(_SURVEY)
    preferences: pd.DataFrame = _table(_PAIRS)
    scales: Mapping[str, Scale] = attrs.field(factory=dict)  # of ratings and survey, by name, from the plan
    notes: tuple[str, ...] = ()  # remarks made while reading

    def parts(self) -> list[str]:
        """Return the parts in the order of the plan, else of appearance."""
        return _in_order(dict.fromkeys([*self.rows["part"], *self.preferences["part"]]), tuple(self.planned))

    def rated_scales(self) -> list[str]:
        """Return the scales that have rows, in the order of the plan: the most important first."""
        return [name for name in self.scale_info if (self.rows["scale"] == name).any()]

    def of(self, part: str, scale: str) -> pd.DataFrame:
        return self.rows[(self.rows["part"] == part) & (self.rows["scale"] == scale)]

    def conditions(self, part: str) -> list[str]:
        """Return a part's conditions in the order of the plan, others by latency and warp."""
        pairs = self.preferences[self.preferences["part"] == part]
        names = dict.fromkeys(
            [*self.rows.loc[self.rows["part"] == part, "condition"], *pairs["first"], *pairs["second"]]
        )
        return _in_order(sorted(names, key=lambda name: _place(self.settings(part, name))), self.planned.get(part, ()))

    @functools.cached_property
    def _known(self) -> dict[tuple[str, str], dict[str, Any]]:
        """What is known of each condition, by part and name: its plan's settings, or SETTINGS."""
        rows = self.rows.drop_duplicates(["part", "condition"]).to_dict("records")
        return {
            (row["part"], row["condition"]): row["settings"]
            if "settings" in row
            else {n: row[n] for n in SETTINGS if n in row and pd.notna(row[n])}
            for row in rows
        }

    def settings(self, part: str, condition: str) -> dict[str, Any]:
        return self._known.get((part, condition), {})

    def references(self, part: str) -> list[str]:
        """Return the names of a part's hidden references."""
        rows, pairs = self.rows, self.preferences
        rated = rows.loc[(rows["part"] == part) & rows["reference"], "condition"]
        return [*dict.fromkeys([*rated, *filter(None, pairs.loc[pairs["part"] == part, "reference"])])]

    def table(self, part: str, scale: str) -> pd.DataFrame:
        """Return participants against conditions; repeats of a condition are averaged."""
        rows = self.of(part, scale)
        means = rows.groupby(["participant", "condition"], sort=False)["value"].mean().unstack()
        return means.reindex(index=rows["participant"].unique(), columns=self.conditions(part))


def _in_order(names: Iterable[str], planned: Sequence[str]) -> list[str]:
    place = {name: number for number, name in enumerate(planned)}
    return sorted(names, key=lambda name: place.get(name, len(place)))


def _place(settings: Mapping[str, Any]) -> tuple[Any, ...]:
    warp, latency = settings.get("warp", ""), settings.get("latency_ms")
    bare = warp in ("", "none")
    return (True, not bare) if latency is None else (False, not bare, warp, latency)


# --- from a study's store


def from_contents(contents: Contents, design: Design, origin: str = PERSON) -> Ratings:
    """Return the ratings of one origin, by each session's own plan; a nameless part has no name."""
    kept = of_origin(contents, origin)
    if not kept.sessions:
        raise InputError(no_sessions(contents, origin, "analyse"))
    rows: dict[str, list[dict[str, Any]]] = {"rows": [], "survey": [], "preferences": [], "sessions": []}
    only = [part.name for part in design.parts] == [ONLY_PART]
    for data in sessions_of(kept, design):
        session, judged, name = data.session, set[int](), "" if only else data.session.part
        scored = {scale.name for scale in data.plan.scales if scale.kind == RATING}
        for ask in data.asks.values():
            row = answer_row(design, data, ask) | {"place": ask.trial, "part": name}
            row["why_missing"] = _WHY.get(row["why_missing"] or "", "")
            if ask.scale.kind == PREFERENCE:
                second, part = data.shows[ask.about], data.plan.part(session.part)
                row |= {"second": second.condition.name, "answer": row["value"], "allows_ties": ask.scale.allows_ties}
                row["reference"] = next((one.name for one in part.conditions if one.reference), "")
                rows["preferences"].append(row)
            elif ask.scale.kind == RATING and ask.phase == "trial":
                planned = data.shows[ask.about].condition.settings.items()
                settings = {"latency_ms" if key == "latency" else key: value for key, value in planned}
                rows["rows"].append(row | {"settings": settings})
            else:  # a rating before or after the trials is of no condition
                if row["value"] is not None and ask.scale.name not in scored:
                    rows["survey"].append(row)
                continue
            judged |= {ask.trial} if row["value"] is not None else set()
        about = {"participant": session.sub, "part": name, "session": session.number, "status": session.status}
        counts = {"rated": len(judged), "planned": sum(map(len, session.order))}
        rows["sessions"].append({**about, "why": session.why, **counts})
    families = design.families
    if only:
        unnamed = (tuple(attrs.evolve(one, part="") for one in family.comparisons) for family in families)
        families = tuple(Family(family.name, made) for family, made in zip(families, unnamed, strict=True))
    return Ratings(
        **rows,
        scale_info={scale.name: ScaleInfo.of(scale) for scale in design.scales if scale.kind == RATING},
        families=families,
        planned={"" if only else part.name: tuple(one.name for one in part.conditions) for part in design.parts},
        origin=origin,
        source=f"the store of '{contents.name}'",
        title=design.title,
        scales={scale.name: scale for scale in every_scale(design)},
        notes=tuple(_notes(contents, kept, design, origin)),
    )


def _notes(contents: Contents, kept: Contents, design: Design, origin: str) -> Iterable[str]:
    others = {session.origin for session in contents.sessions} - {origin}
    again = pd.Series([session.sub for session in kept.sessions]).value_counts().gt(1).sum()
    if origin != PERSON:
        yield f"These ratings are of origin '{origin}', not of people taking part in the study."
    if others:
        yield f"Sessions of origin {' and '.join(sorted(others))} are left out: origins are never mixed."
    if changed := sum(session.plan != design.text for session in kept.sessions):
        those = f"{changed} of {counted(len(kept.sessions), 'session')}"
        yield f"The study's file was changed after {those}; each is read by the plan that it ran with."
    if again:
        yield f"Participants with more than one session: {again}; their ratings of a condition are averaged."
    refused, never = without_consent(contents, origin)
    if refused:
        yield f"Declined to take part, and counted nowhere else: {refused}."
    if never:
        yield f"Left before the consent was given, and counted nowhere else: {never}."
    if contents.withdrawn:
        yield f"Withdrawn, with all data erased: {contents.withdrawn}."


# --- from a table, one rating in a line

# Columns of each role: those of an export, and of the ratings that the thesis published.
ROLES: Mapping[str, tuple[str, ...]] = {
    "participant": ("participant",),
    "rating": ("value", "rating"),
    "part": ("part", "run"),
    "place": ("trial",),
    **{name: (name,) for name in ("condition", "repeat", "session", "reference", *SETTINGS)},
    **{name: (name,) for name in ("previous", "scale", "item", "origin", "status", "low_is_good")},
}
_MISSING = frozenset({"", "n/a", "na", "nan", "null", "none", ".", "-", "?", "missing"})
_ORIGINS = ("person", "simulated", "pilot")


@attrs.frozen
class SourceOptions:
    """What a table does not say itself."""

    columns: Mapping[str, str] = attrs.field(factory=dict, hash=False)  # role to column name
    scale: str = ""  # a shipped one's name or a file
    low_is_good: bool | None = None  # None where not known
    origin: str = ""  # whose ratings, where there are several; "" for people first
    missing: tuple[str, ...] = ()  # ratings that stand for none, such as 99


def from_csv(path: Path, options: SourceOptions = SourceOptions()) -> Ratings:  # noqa: B008  (frozen)
    """Read the ratings of a long table, one per row.

    Columns have the names of an export (ROLES) unless options name them; between is , ; or tab.
    An empty field is a missing rating. Several ratings of one participant of one condition are
    repeats. A decimal comma is read as such where no value has a point.
    Errors: InputError naming the file, the line, what was found and what was expected.
    """
    data, part_column = _lines(path, options.columns)
    data, origin, notes = _of_one_origin(data, path, options.origin)
    data["value"], comma = _values(data, path, options)
    one = data["participant"].groupby(data["participant"].str.casefold()).transform("first")
    if (other := one[one != data["participant"]]).any():
        notes.append(f"Names that differ by case alone are one participant: {listed(sorted({*other}))}.")
    data["participant"] = one
    if comma:
        notes.append("Ratings have a decimal comma: 3,25 was read as 3.25.")
    infos, unnamed = {}, ""
    for name in data["scale"].unique():
        if (info := _scale_info(name, data[data["scale"] == name], path, options, notes)) is not None:
            infos[name or info.name] = info
            unnamed = unnamed if name else info.name
    _check(path, data["participant"], ~_lacks(data["participant"]), "no participant: every rating needs one")
    for role, default in (("place", 0), ("session", 1), ("repeat", 1)):
        found = data[role].astype(str).str.extract(r"^(?:\w+-)?([0-9]{1,9})(?:\.0+)?$")[0]
        _check(path, data[role], found.notna() | _lacks(data[role]), f"{role} '{{}}': expected a whole number")
        data[role] = pd.to_numeric(found).fillna(default).astype(int)
    if part_column:
        data["part"] = data["part"].str.replace(
            r"^([0-9]+)$", rf"{part_column} \1", regex=True
        )  # "run 1", where "run" holds 1
    data["scale"] = data["scale"].replace("", unnamed)
    data["reference"] = data["reference"].str.lower().isin(("true", "1", "yes"))
    is_rating = data["scale"].isin(infos)
    survey = data[~is_rating].assign(trial=data["place"], phase=data["phase"].where(data["place"] == 0, "trial"))
    rows = _with_conditions(data[is_rating], path)
    if rows.empty:
        raise InputError(f"{path}: holds no ratings: {counted(len(data), 'row')}, none of them on a rating scale")
    if repeated := (rows.groupby(["participant", "part", "condition", "scale"]).size() > 1).sum():
        notes.append(
            f"A participant rated a condition more than once, {counted(int(repeated), 'time')}: the mean counts."
        )
    for name in rows.columns[rows.columns.str.match("(actual|measured)_") & (rows.columns != "measured_size")]:
        rows[name] = rows[name].map(_number)
    rows["low_is_good"] = rows["scale"].map({name: info.low_is_good for name, info in infos.items()})
    return Ratings(
        rows,
        infos,
        origin=origin,
        source=path.name,
        title=path.stem,
        survey=survey.dropna(subset="value"),
        notes=tuple(notes),
    )


def _lines(path: Path, named: Mapping[str, str]) -> tuple[pd.DataFrame, str]:
    """Return the texts by role and other columns, rows by their lines, and the part's column."""
    text = text_in(path, RATINGS)
    if not text.strip():
        raise InputError(f"{path}: is empty: expected a table of ratings, a header and one row for each rating")
    delimiter = max("\t;,", key=text.split("\n", 1)[0].count)
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter, strict=True)
    rows: dict[int, list[str]] = {}
    try:
        header = [name.strip() for name in next(reader, [])]
        for cells in reader:
            if any(cell.strip() for cell in cells):
                rows[reader.line_num] = [raw_text(cell).strip() for cell in cells]
                if len(cells) != len(header):
                    wanted = f"{len(cells)} fields, expected {len(header)} as in the first line"
                    raise InputError(f"{path}:{reader.line_num}: {wanted}")
    except csv.Error as error:
        raise InputError(f"{path}:{reader.line_num}: {error}: expected a table with one rating per row") from error
    roles = _roles(header, named, str(path))
    if not rows:
        raise InputError(f"{path}: has no rows below its header: expected one for each rating")
    table = pd.DataFrame.from_dict(rows, orient="index", dtype=object)
    others = {name: at for at, name in enumerate(header) if at not in roles.values() and name not in roles}
    found = pd.DataFrame({name: table[at] for name, at in {**others, **roles}.items()})
    for name in {*COLUMNS, "item", "phase", "origin", "status", "low_is_good"} - {"value"}:
        found[name] = found.get(name, "")
    return found, header[roles["part"]] if "part" in roles else ""


def _roles(header: Sequence[str], named: Mapping[str, str], path: str) -> dict[str, int]:
    """Return the column of each role. named: role to column name, from the user."""
    found: dict[str, int] = {}
    for role, name in named.items():
        if role not in ROLES:
            raise InputError(f"--columns {role}={name}: expected one of {', '.join(ROLES)} before the '='")
        if name not in header:
            raise InputError(f"{path}:1: no column '{name}' (--columns {role}={name}); there are {', '.join(header)}")
        found[role] = header.index(name)
    for role, names in ROLES.items():
        known = [name for name in names if name in header and header.index(name) not in found.values()]
        if role not in found and known:
            found[role] = header.index(known[0])
    lacking = [role for role in ("participant", "rating") if role not in found]
    lacking += [] if {"condition", *SETTINGS} & set(found) else ["condition"]
    if lacking:
        free = [name for name in header if header.index(name) not in found.values()] or header
        example = ",".join(f"{role}={name}" for role, name in zip(lacking, free, strict=False))
        raise InputError(
            f"{path}:1: no column named {listed(lacking)} among {', '.join(header)}: name each, as in --columns "
            f"'{example}'"
        )
    return found


def _lacks(texts: pd.Series, but: str | None = None) -> pd.Series:
    return texts.str.lower().isin(_MISSING - {but})


def _check(path: Path, texts: pd.Series, right: pd.Series, says: str) -> None:
    """Refuse the first text that is not right. Errors: InputError with its line."""
    for line, text in texts[~right].items():
        raise InputError(f"{path}:{line}: {says.replace('{}', str(text))}")


def _number(text: str) -> float:
    try:
        return math.nan if "_" in text else float(text)
    except ValueError:
        return math.nan


def _values(data: pd.DataFrame, path: Path, options: SourceOptions) -> tuple[pd.Series, bool]:
    """Return each rating, NaN where missing, and whether they have decimal commas."""
    anchors = load_scale(options.scale).anchors if options.scale else {}
    answers = {words.casefold(): f"{value:g}" for value, words in anchors.items()}
    texts = data["rating"].map(lambda text: answers.get(text.casefold(), text))
    missing = _lacks(texts) | texts.isin(options.missing)
    comma = (
        texts.str.fullmatch(r"[+-]?[0-9]+,[0-9]+").any() and not texts[~missing].str.contains(".", regex=False).any()
    )
    texts = texts.str.replace(",", ".") if comma else texts
    values = texts.map(_number).astype(float)
    named = f", or a word of '{options.scale}': {listed(list(anchors.values()))}" if anchors else ""
    wanted = f"expected a number with a decimal point{named}, or an empty field or --missing CODE where it is missing"
    _check(path, texts, missing | values.map(math.isfinite), f"rating '{{}}': {wanted}")
    return values.mask(missing), comma


def _of_one_origin(data: pd.DataFrame, path: Path, wanted: str) -> tuple[pd.DataFrame, str, list[str]]:
    whose = data["origin"].replace("", PERSON)
    there = whose.value_counts(sort=False)
    origin = wanted or next((name for name in _ORIGINS if name in there), there.index[0])
    if origin not in there:
        raise InputError(f"{path}: no ratings of origin '{origin}': there are {', '.join(sorted(there.index))}")
    notes = (
        [] if origin == PERSON else [f"These ratings are of origin '{origin}', not of people taking part in the study."]
    )
    left = [f"{counted(int(there[name]), 'row')} of {name}" for name in sorted(there.index) if name != origin]
    notes += [f"Left out, because origins are never mixed: {', '.join(left)}."] if left else []
    return data[whose == origin].copy(), origin, notes


def _scale_info(name: str, own: pd.DataFrame, path: Path, options: SourceOptions, notes: list[str]) -> ScaleInfo | None:
    """Return a scale by its name, else as user or table describe it; None for a survey."""
    if known := options.scale or (name if name in scale_names() else ""):
        scale = load_scale(known)
        if scale.kind != RATING and name:
            return None
        limits = f"the scale '{scale.name}' goes from {scale.least:g} to {scale.most:g}"
        right = own["value"].isna() | own["value"].between(scale.least, scale.most)
        _check(path, own["value"].map("{:g}".format), right, f"rating {{}}: {limits}")
        return ScaleInfo.of(scale)
    low = _low_is_good(own, path) if options.low_is_good is None else options.low_is_good
    if low is not None:
        return ScaleInfo(name or "rating", name or "Rating", low)
    grade = load_scale("grade")
    # A value above 5 cannot be one of the five ACR categories; whole numbers from 1 to 5 fit either
    # direction.
    if own["value"].min() >= grade.least and 5 < own["value"].max() <= grade.most:
        notes.append(
            f"The table does not give the direction of its ratings. All lie in {grade.least:g} to {grade.most:g}, "
            "so they are read on the scale 'grade', where 1 is the best. Otherwise use --scale NAME, --low-is-good or "
            "--high-is-good."
        )
        return ScaleInfo.of(grade)
    raise InputError(
        f"{path}: the direction of the ratings is unknown: use --low-is-good, --high-is-good, or --scale with one of "
        f"{', '.join(scale_names())}"
    )


def _low_is_good(own: pd.DataFrame, path: Path) -> bool | None:
    """Return what the table says of the scale's direction, None where it says nothing."""
    said = own["low_is_good"].str.lower().map({"true": True, "1": True, "false": False, "0": False}).dropna()
    if said.empty:
        return None
    first = f"'{own['low_is_good'][said.index[0]]}' in line {said.index[0]}"
    wanted = f"low_is_good '{{}}', and {first}: expected one direction for all ratings on a scale"
    _check(path, own["low_is_good"][said.index], said == said.iloc[0], wanted)
    return bool(said.iloc[0])


def _with_conditions(rows: pd.DataFrame, path: Path) -> pd.DataFrame:
    """Name each row's condition and the one before it; the practice has none, and is left out."""
    for name in SETTINGS:
        rows[name] = rows[name].mask(_lacks(rows[name], but="none"), None) if name in rows else None
    latency = rows["latency_ms"].dropna()
    numbers = latency.map(_number)
    _check(path, latency, numbers.notna(), "latency '{}': expected milliseconds, like 200")
    rows["latency_ms"] = numbers.astype(float).reindex(rows.index)
    by_settings = rows[list(SETTINGS)].apply(lambda row: name_of(row.dropna().to_dict()), axis=1)
    has_column = (rows["condition"] != "").any()
    rows["condition"] = rows["condition"].mask(_lacks(rows["condition"], but="none"), "") if has_column else by_settings
    rows = rows[rows["condition"] != ""].copy()
    rows["previous"] = rows["previous"].mask(_lacks(rows["previous"]), "")
    key = ["participant", "part", "session", "place"]
    at = dict(zip(rows[key].itertuples(index=False, name=None), rows["condition"], strict=True))
    before = [at.get((*who, place - 1), "") if place > 1 else "" for *who, place in rows[key].itertuples(index=False)]
    rows["previous"] = rows["previous"].where(rows["previous"] != "", pd.Series(before, rows.index, dtype=object))
    status = rows["status"].map(lambda text: "" if text in ("", "complete") else f"; the session's status is '{text}'")
    empty = "empty in line " + rows.index.astype(str) + status
    said = rows["why_missing"].map(lambda text: _WHY.get(text, text))
    rows["why_missing"] = said.mask(_lacks(rows["why_missing"]), empty).where(rows["value"].isna(), "")
    return rows


def name_of(settings: Mapping[str, Any]) -> str:
    """Name a condition by its settings, like "forward + interpolate, 200 ms"."""
    passes = [str(settings[name]) for name in ("warp", "fill") if settings.get(name)]
    if passes[1:] == ["none"]:
        passes.pop()
    latency = f"{settings['latency_ms']:g} ms" if "latency_ms" in settings else ""
    return ", ".join(filter(None, (" + ".join(passes), latency, settings.get("scene"))))


# --- as the command line names them


def ratings_from(name: str, store: Path | None, options: SourceOptions) -> Ratings:
    """Return the ratings of a table or of a study's store; published ones where it has none."""
    if not name.endswith(".toml") and Path(name).is_file():
        return from_csv(Path(name), options)
    if name.endswith((".csv", ".tsv", ".txt")):
        raise InputError(
            f"{name}: no such file: expected a table of ratings, a study's .toml file, or a shipped study's name"
        )
    design = load_design(name, checked=False)
    origin = options.origin or PERSON
    published = SHIPPED / f"{name}_ratings.csv"
    if store is None and published.is_file() and not (stored.store_folder(design, None, origin) / DATABASE).exists():
        scale = options.scale or next(scale.name for scale in design.scales if scale.kind == RATING)
        return attrs.evolve(from_csv(published, attrs.evolve(options, scale=scale)), title=design.title)
    with Store(stored.folder_to_read(design, store, origin), study=design.name) as data:
        return from_contents(data.contents(pilot=origin == PILOT), design, origin)


def ratings_from_all(names: Sequence[str], store: Path | None, options: SourceOptions) -> Ratings:
    """Return the ratings of one source, or of tables of one origin and the same scales."""
    if len(names) == 1:
        return ratings_from(names[0], store, options)
    every, seen = list[Ratings](), dict[tuple[str, str, int], str]()
    for name in names:
        if name.endswith(".toml") or not Path(name).is_file():
            wanted = "beside other sources expected a table of ratings that is there: export each study first"
            raise InputError(f"{name}: {wanted} ('hmdwarp study export')")
        every.append(ratings := from_csv(Path(name), options))
        if ratings.origin != every[0].origin:
            raise InputError(f"{name}: ratings of origin '{ratings.origin}', and '{every[0].origin}' in {names[0]}")
        for scale, info in ratings.scale_info.items():
            if every[0].scale_info.get(scale, info) != info:
                raise InputError(f"{name}: scale '{scale}' is another one than in {names[0]}")
        for who in dict.fromkeys(ratings.rows[["participant", "part", "session"]].itertuples(index=False, name=None)):
            if (other := seen.setdefault(who, name)) != name:
                raise InputError(
                    f"{name}: has session {who[2]} of participant '{who[0]}', as {other} has: is one a copy of the "
                    "other? Expected each rating once, and a name of their own for each person"
                )
    return attrs.evolve(
        every[0],
        rows=pd.concat([each.rows for each in every], ignore_index=True),
        survey=pd.concat([each.survey for each in every], ignore_index=True),
        scale_info={name: info for each in every for name, info in each.scale_info.items()},
        source=", ".join(each.source for each in every),
        title=", ".join(dict.fromkeys(each.title for each in every)),
        notes=tuple(dict.fromkeys(note for each in every for note in each.notes)),
    )
