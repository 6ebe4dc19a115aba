"""Ratings from any source, and what else is known of the people who gave them."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..design import Family
from ..scales import Scale


@attrs.frozen
class Rating:
    """One value, or the reason why it is missing."""

    participant: str  # a random id, or what the file calls them
    part: str
    condition: str  # its name
    scale: str  # a key of Ratings.scale_info
    value: float | None
    why_missing: str = ""
    reference: bool = False  # whether the condition is the hidden reference
    repeat: int = 1  # presentations of the condition so far, this one included
    place: int = 0  # number of its trial in the session; 0 where not recorded
    previous: str = ""  # condition shown before; "" for the first or where not recorded
    session: int = 1
    settings: Mapping[str, Any] = attrs.field(factory=dict, hash=False)


@attrs.frozen
class Preference:
    """One answer about a pair, or the reason why it is missing."""

    participant: str
    part: str
    scale: str
    first: str  # name of the condition shown first
    second: str
    answer: float | None  # FIRST, SECOND or NEITHER of study.scales
    allows_ties: bool = False  # whether NEITHER could be chosen
    reference: str = ""  # name of the part's hidden reference, "" for none
    why_missing: str = ""
    repeat: int = 1
    place: int = 0  # number of its trial
    session: int = 1


@attrs.frozen
class ScaleInfo:
    """Direction, range and unit of a scale of ratings."""

    name: str
    title: str
    low_is_good: bool
    least: float | None = None  # None where not known, as `most`
    most: float | None = None
    unit: str = "points"  # or "grades"
    mean_name: str = "mean"  # of a condition's ratings: "DMOS" where they are relative to a reference

    @classmethod
    def of(cls, scale: Scale) -> ScaleInfo:
        """Take it from a scale."""
        unit = "grades" if scale.name == "grade" else "points"
        mean_name = "DMOS" if scale.beside_reference else "mean"
        return cls(scale.name, scale.title, scale.low_is_good, scale.least, scale.most, unit, mean_name)

    @property
    def sign(self) -> int:
        """Factor that turns "baseline minus condition" into "the condition is better"."""
        return 1 if self.low_is_good else -1


@attrs.frozen
class SessionSummary:
    """How far a session got."""

    participant: str
    part: str
    number: int
    status: str  # as in study.store
    why: str
    rated: int  # trials that have a rating
    planned: int


@attrs.frozen
class SurveyAnswer:
    """An answer that is no rating: to a sickness scale or a questionnaire."""

    participant: str
    part: str
    session: int
    phase: str  # "before", "practice", "trial" or "after"
    trial: int
    scale: str
    item: str
    value: float | None


@attrs.frozen(eq=False)
class Ratings:
    """All ratings of one origin: people, pilots and simulated participants are never mixed."""

    rows: tuple[Rating, ...]  # in the order of the trials, as far as it is known
    scale_info: Mapping[str, ScaleInfo]
    families: tuple[Family, ...] = ()  # planned comparisons
    planned: Mapping[str, tuple[str, ...]] = attrs.field(factory=dict)  # conditions by part, as planned
    origin: str = "person"
    source: str = ""  # for messages
    title: str = ""
    sessions: tuple[SessionSummary, ...] = ()
    survey: tuple[SurveyAnswer, ...] = ()
    preferences: tuple[Preference, ...] = ()  # of paired comparisons
    scales: Mapping[str, Scale] = attrs.field(factory=dict)  # of ratings and survey, by name, from the plan
    notes: tuple[str, ...] = ()  # remarks made while reading
    long: tuple[Mapping[str, Any], ...] = attrs.field(default=(), repr=False)  # rows of the long table

    def parts(self) -> tuple[str, ...]:
        """Return the parts in the order of the plan, else of appearance."""
        rated, compared = (row.part for row in self.rows), (preference.part for preference in self.preferences)
        return _in_order(dict.fromkeys((*rated, *compared)), tuple(self.planned))

    def rated_scales(self) -> tuple[str, ...]:
        """Return the scales that have rows, in the order of the plan: the most important first."""
        found = {row.scale for row in self.rows}
        return tuple(name for name in self.scale_info if name in found)

    def of(self, part: str, scale: str) -> tuple[Rating, ...]:
        """Return the rows of a part on one scale."""
        return tuple(row for row in self.rows if row.part == part and row.scale == scale)

    def conditions(self, part: str) -> tuple[str, ...]:
        """Return a part's conditions that were rated or compared.

        In the order of the plan, others last. Without a plan by settings that are numbers
        (latency), else in order of appearance.
        """
        names = dict.fromkeys(row.condition for row in self.rows if row.part == part)
        names |= dict.fromkeys(
            name
            for preference in self.preferences
            if preference.part == part
            for name in (preference.first, preference.second)
        )
        by_settings = sorted(names, key=lambda name: _place_of(self.settings(part, name)))
        return _in_order(by_settings, self.planned.get(part, ()))

    def settings(self, part: str, condition: str) -> Mapping[str, Any]:
        """Return a condition's settings, empty where none are known."""
        return next((row.settings for row in self.rows if row.part == part and row.condition == condition), {})

    def references(self, part: str) -> tuple[str, ...]:
        """Return the names of a part's hidden references."""
        compared = (
            preference.reference for preference in self.preferences if preference.part == part and preference.reference
        )
        rated = (row.condition for row in self.rows if row.part == part and row.reference)
        return tuple(dict.fromkeys((*rated, *compared)))

    def table(self, part: str, scale: str) -> Table:
        """Return the table of participants against conditions."""
        return Table.of(self.of(part, scale), self.conditions(part))


def _in_order(names: Iterable[str], planned: Sequence[str]) -> tuple[str, ...]:
    place = {name: number for number, name in enumerate(planned)}
    return tuple(sorted(names, key=lambda name: place.get(name, len(place))))


def _place_of(settings: Mapping[str, Any]) -> tuple[Any, ...]:
    warp = str(settings.get("warp", ""))
    latency = settings.get("latency_ms", settings.get("latency"))
    return (
        latency is None,
        warp not in ("", "none"),
        warp if latency is not None else "",
        latency if latency is not None else 0.0,
    )


@attrs.frozen(eq=False)
class Table:
    """Ratings of one part on one scale; repeats of a condition are averaged."""

    participants: tuple[str, ...]
    conditions: tuple[str, ...]
    values: NDArray[np.float64]  # (participants, conditions), NaN for missing
    counts: NDArray[np.int64]  # ratings in each mean

    @classmethod
    def of(cls, rows: tuple[Rating, ...], conditions: tuple[str, ...]) -> Table:
        """Make it from rows of one part on one scale."""
        people = tuple(dict.fromkeys(row.participant for row in rows))
        at = {name: number for number, name in enumerate(people)}
        column = {name: number for number, name in enumerate(conditions)}
        sums, counts = np.zeros((len(people), len(conditions))), np.zeros((len(people), len(conditions)), np.int64)
        for row in rows:
            if row.value is not None:
                sums[at[row.participant], column[row.condition]] += row.value
                counts[at[row.participant], column[row.condition]] += 1
        values = np.where(counts > 0, sums / np.maximum(counts, 1), np.nan)
        return cls(people, conditions, values, counts)

    def column(self, condition: str) -> NDArray[np.float64]:
        """Return a condition's ratings, one per participant.

        Errors: ValueError for another name.
        """
        return self.values[:, self.conditions.index(condition)]

    def without(self, participants: set[str]) -> Table:
        """Leave out these participants."""
        keep = [number for number, name in enumerate(self.participants) if name not in participants]
        return Table(tuple(self.participants[k] for k in keep), self.conditions, self.values[keep], self.counts[keep])


_LEAST_CONDITIONS = 2  # equal ratings of one condition say nothing
_DRAWS = 20_000
_MISSING = -np.inf  # equal to itself, and no rating


def copied_rows(ratings: Ratings, scale: str, seed: int) -> list[dict[str, Any]]:
    """Return, for every two parts with conditions in common, the rows that are equal there.

    Conditions are common by name or by settings; missing ratings count as equal.
    "by_chance": how often as many people of the second part would have an equal row in the first if
    every rating were drawn by itself from all ratings of its condition (seeded draws). "within":
    equal rows among the people of one part, of all pairs: how common they are without copying.
    """
    found = []
    for first, second in itertools.combinations(ratings.parts(), 2):
        shared = _shared(ratings, first, second)
        if len(shared) < _LEAST_CONDITIONS:
            continue
        tables = [
            _columns(ratings.table(part, scale), [pair[k] for pair in shared]) for k, part in enumerate((first, second))
        ]
        pairs = _equal(*tables)
        if not pairs:
            continue
        names = [ratings.table(part, scale).participants for part in (first, second)]
        people = len({b for _, b in pairs})
        found.append(
            {
                "parts": [first, second],
                "conditions": [a for a, _ in shared],
                "rows": [
                    {"first": names[0][a], "second": names[1][b], "ratings": _plain(tables[0][a])} for a, b in pairs
                ],
                "people": people,
                "of": len(names[1]),
                "by_chance": _by_chance(tables[0], tables[1], people, seed),
                "draws": _DRAWS,
                "within": sum(len(_within(table)) for table in tables),
                "within_of": sum(len(table) * (len(table) - 1) // 2 for table in tables),
            }
        )
    return found


def _shared(ratings: Ratings, first: str, second: str) -> list[tuple[str, str]]:
    """Return the conditions of both, as (name in the first, name in the second)."""
    pairs = []
    for a in ratings.conditions(first):
        own = ratings.settings(first, a)
        for b in ratings.conditions(second):
            other = ratings.settings(second, b)
            if (own == other) if own and other else a == b:
                pairs.append((a, b))
                break
    return pairs


def _columns(table: Table, names: list[str]) -> np.ndarray:
    """Return ratings (participants, conditions), missing ones as _MISSING, equal to each other."""
    values = np.stack([table.column(name) for name in names], axis=1)
    return np.where(np.isfinite(values), np.round(values, 6), _MISSING)


def _plain(row: np.ndarray) -> list[float | None]:
    return [None if value == _MISSING else float(value) for value in row]


def _equal(first: np.ndarray, second: np.ndarray) -> list[tuple[int, int]]:
    same = (first[:, None] == second[None]).all(axis=2) & (first != _MISSING).any(axis=1)[:, None]
    return [(int(a), int(b)) for a, b in np.argwhere(same)]


def _within(table: np.ndarray) -> list[tuple[int, int]]:
    return [(a, b) for a, b in _equal(table, table) if a < b]


def _by_chance(first: np.ndarray, second: np.ndarray, people: int, seed: int) -> float:
    """Return the share of draws with as many equal rows; the data count as one draw."""
    random = np.random.default_rng(seed)
    pool = np.concatenate([first, second])
    n, columns = len(pool), np.arange(pool.shape[1])
    hits = 1
    for start in range(0, _DRAWS, 2000):  # little memory at a time
        count = min(2000, _DRAWS - start)
        drawn = pool[random.integers(0, n, (count, n, pool.shape[1])), columns]
        a, b = drawn[:, : len(first)], drawn[:, len(first) :]
        same = (a[:, :, None] == b[:, None]).all(axis=3) & (a != _MISSING).any(axis=2)[:, :, None]
        hits += int((same.any(axis=1).sum(axis=1) >= people).sum())
    return hits / (_DRAWS + 1)
