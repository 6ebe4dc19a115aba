"""The nouns of an analysis: ratings, wherever they came from, and what else is known of the people who gave them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..design import Family
from ..scales import Scale


@attrs.frozen
class Rating:
    """One value, or why there is none.

    participant: a random id, or what the file calls them. condition: its name. reference: whether it is the hidden reference. repeat: which
    time it was shown, from 1 on. place: number of its trial in the session, 0 where that is not recorded. previous: the condition shown
    before, "" for the first or not recorded. scale: a name in Ratings.measures. value: None where missing, with why_missing then.
    """

    participant: str
    part: str
    condition: str
    scale: str
    value: float | None
    why_missing: str = ""
    reference: bool = False
    repeat: int = 1
    place: int = 0
    previous: str = ""
    session: int = 1
    settings: Mapping[str, Any] = attrs.field(factory=dict, hash=False)


@attrs.frozen
class Measure:
    """What values are measured on: a scale's direction and range. least, most: None where not known. unit: "grades", "points"."""

    name: str
    title: str
    low_is_good: bool
    least: float | None = None
    most: float | None = None
    unit: str = "points"

    @classmethod
    def of(cls, scale: Scale) -> Measure:
        """That of a scale."""
        return cls(
            scale.name,
            scale.title,
            scale.low_is_good,
            scale.least,
            scale.most,
            "grades" if scale.name == "grade" else "points",
        )

    @property
    def sign(self) -> int:
        """What turns "a minus b" into "b is better"."""
        return 1 if self.low_is_good else -1


@attrs.frozen
class Sitting:
    """A session as far as it went. status: as in study.store. shown: trials that have a rating, of `planned`."""

    participant: str
    part: str
    number: int
    status: str
    why: str
    shown: int
    planned: int


@attrs.frozen
class Felt:
    """An answer that is no rating: of sickness, or to a questionnaire. phase: "before", "practice", "trial" or "after"."""

    participant: str
    part: str
    session: int
    phase: str
    trial: int
    scale: str
    item: str
    value: float | None


@attrs.frozen(eq=False)
class Ratings:
    """All ratings of one origin: people, pilots and simulated participants never come together.

    rows: in the order of the trials, as far as it is known. measures: by scale. families: the planned ones. planned: a plan's conditions by
    part, both in its order; empty where there is no plan. source: where it all is from.
    felt: sickness and questionnaires. others: their scales by name, as the plan has them. notes: what was noticed while reading. long: the
    rows of the long table, for what is joined with ratings.
    """

    rows: tuple[Rating, ...]
    measures: Mapping[str, Measure]
    families: tuple[Family, ...] = ()
    planned: Mapping[str, tuple[str, ...]] = attrs.field(factory=dict)
    origin: str = "person"
    source: str = ""
    title: str = ""
    sittings: tuple[Sitting, ...] = ()
    felt: tuple[Felt, ...] = ()
    others: Mapping[str, Scale] = attrs.field(factory=dict)
    notes: tuple[str, ...] = ()
    long: tuple[Mapping[str, Any], ...] = attrs.field(default=(), repr=False)

    def parts(self) -> tuple[str, ...]:
        """Their names, in the order of the plan, else of appearance."""
        return _in_order(dict.fromkeys(row.part for row in self.rows), tuple(self.planned))

    def scales(self) -> tuple[str, ...]:
        """Names of the measures that have rows, in the order of the measures: a plan names the one that matters most first."""
        found = {row.scale for row in self.rows}
        return tuple(name for name in self.measures if name in found)

    def of(self, part: str, scale: str) -> tuple[Rating, ...]:
        """The rows of a part on one scale."""
        return tuple(row for row in self.rows if row.part == part and row.scale == scale)

    def conditions(self, part: str) -> tuple[str, ...]:
        """A part's that have rows, as people would list them: in the order of the plan (what it does not have comes last); without a
        plan by their settings where they are numbers (latency), else in order of appearance."""
        names = dict.fromkeys(row.condition for row in self.rows if row.part == part)
        by_settings = sorted(names, key=lambda name: _place_of(self.settings(part, name)))
        return _in_order(by_settings, self.planned.get(part, ()))

    def settings(self, part: str, condition: str) -> Mapping[str, Any]:
        """Those of a condition, empty where none are known."""
        return next((row.settings for row in self.rows if row.part == part and row.condition == condition), {})

    def references(self, part: str) -> tuple[str, ...]:
        """Names of the hidden references of a part."""
        return tuple(dict.fromkeys(row.condition for row in self.rows if row.part == part and row.reference))

    def table(self, part: str, scale: str) -> Table:
        """Participants against conditions: what Table says."""
        return Table.of(self.of(part, scale), self.conditions(part))


def _in_order(names: Iterable[str], planned: Sequence[str]) -> tuple[str, ...]:
    """The names, planned ones first and as planned."""
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
    """values: (participants, conditions) float64, NaN for missing; repeats of a condition are averaged. counts: how many ratings are in
    each mean."""

    participants: tuple[str, ...]
    conditions: tuple[str, ...]
    values: NDArray[np.float64]
    counts: NDArray[np.int64]

    @classmethod
    def of(cls, rows: tuple[Rating, ...], conditions: tuple[str, ...]) -> Table:
        """From rows of one part on one scale."""
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
        """A condition's ratings, a participant each. Errors: ValueError for another name."""
        return self.values[:, self.conditions.index(condition)]

    def without(self, participants: set[str]) -> Table:
        """The same of the others."""
        keep = [number for number, name in enumerate(self.participants) if name not in participants]
        return Table(tuple(self.participants[k] for k in keep), self.conditions, self.values[keep], self.counts[keep])
