"""Which conventions that have a number differ: none, one or two, and which others fit as well."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence

import attrs
import numpy as np

from .conventions import (
    CENTRE,
    ENCODING,
    FOCAL,
    PIXEL,
    PLANES,
    RAY,
    SCALE,
    TIME,
    differences,
    is_half_a_pixel,
    restored,
)
from .frame_reading import Reading
from .overlap import (
    ALONG,
    FACTOR,
    LATE,
    LOGARITHMS,
    OFFSET,
    PIXEL_X,
    PIXEL_Y,
    WIDE_X,
    WIDE_Y,
    Fitted,
    Noise,
)
from .search import SURE, Candidate, Search, margin

# What is fitted for each; half a pixel is a principal point too.
FITTED = {
    RAY: (ALONG,),
    SCALE: (FACTOR,),
    PLANES: (FACTOR, OFFSET),
    FOCAL: (WIDE_X, WIDE_Y),
    CENTRE: (PIXEL_X, PIXEL_Y),
    TIME: (LATE,),
}
_DECIDES = {**{numbers: numbers for numbers in FITTED.values()}, (FACTOR, OFFSET): (OFFSET,)}
_SECOND = 4  # times as sure: a number may stand in for what another convention leaves
_NO_WORSE = 2.0  # standard errors of the cost, which says less than the fitted number itself
# Below these a number is as stated; pixels, or a share of the width.
_SCALE, _OFFSET, _LATE, _WIDE, _CENTRE_PX, _CENTRE = 0.05, 0.05, 0.1, 0.015, 0.75, 0.005
_MOST = 0.95  # of the inverse depth of what is farthest: a far plane beyond it moves it by less


def numbered(reading: Reading) -> tuple[str, ...]:
    """Return the keys of FITTED in which a reading differs from what is stated."""
    return tuple(CENTRE if name == PIXEL else name for name in differences(reading) if name in (*FITTED, PIXEL))


def without_numbers(reading: Reading) -> Reading:
    """Return the reading with the conventions of FITTED as stated."""
    while names := numbered(reading):  # below other planes there may be a scale
        reading = restored(reading, names[0])
    return reading


def matters(search: Search, name: str, found: Reading) -> bool:
    """Return whether a number differs so much from what is stated that it has a name."""
    if name == RAY:
        return found.along > 0.5
    if name == FOCAL:
        return max(abs(math.log(found.wide_x)), abs(math.log(found.wide_y))) > _WIDE
    if name == CENTRE:
        least = max(_CENTRE_PX, _CENTRE * search.stated.frames[0].depth.shape[1])
        return is_half_a_pixel(found) or max(abs(found.pixel_x), abs(found.pixel_y)) > least
    if name == TIME:
        assert search.stated.interval_s is not None
        return abs(found.late_s) > _LATE * search.stated.interval_s
    if name == PLANES:
        return _OFFSET * search.farthest(found) < abs(found.offset) and found.offset > -_MOST * search.farthest(found)
    return abs(math.log(found.factor)) > _SCALE


@attrs.frozen(eq=False)
class Numbers:
    """What was found: the best reading, those that fit as well, and what differs besides."""

    best: Candidate
    rivals: tuple[Candidate, ...]
    besides: tuple[str, ...]
    noise: Noise


class NumberSearch:
    """Readings that differ from a leader in its numbers alone, each fitted to the fine pictures."""

    def __init__(self, search: Search, leader: Candidate, seeds: Sequence[Reading]) -> None:
        self.search, self.base = search, without_numbers(leader.reading)
        self._always = (FACTOR, OFFSET) if ENCODING in differences(self.base) else ()
        known = search.steps(self.base)
        self._names = [
            name
            for name, numbers in FITTED.items()
            if set(numbers) <= set(known) and not (self._always and name in (SCALE, PLANES))
        ]
        self._seeds = [self.base, *(seed for seed in seeds if without_numbers(seed) == self.base)]
        if differences(self.base):
            ways = (*search.cameras(self.base), search.late(self.base))
            self._seeds += [search.best(way) for way in ways if way]
        self._models: dict[tuple[str, ...], Candidate] = {}
        self.noise = Noise.of(search.fine.residuals(leader.reading))
        self._every = self._fit_all(leader.reading)
        self.noise = Noise.of(search.fine.residuals(self._every.reading))

    def found(self) -> Numbers:
        """Return which numbers differ: none, one convention, or two where one leaves too much."""
        nothing = self._candidate(self._fit(self.base, ()))
        needed = SURE if not nothing.changes else _SECOND * SURE
        singles = [
            model for model in self._of(1) if self._is_known(model, needed) and self._gains(nothing, model, needed)
        ]
        best, rivals = self._least(nothing, singles)
        besides = self._besides(best)
        if besides and not nothing.changes:
            pairs = [model for model in self._of(2) if self._is_known(model, SURE) and margin(best, model) > SURE]
            best, rivals = self._least(best, pairs) if pairs else (best, rivals)
            besides = self._besides(best) if pairs else besides
        return Numbers(best, rivals, besides, self.noise)

    def _of(self, count: int) -> Iterator[Candidate]:
        for names in itertools.combinations(self._names, count):
            if not {SCALE, PLANES} <= set(names):
                yield self._model(names)

    def _least(self, otherwise: Candidate, found: Sequence[Candidate]) -> tuple[Candidate, tuple[Candidate, ...]]:
        """Return the best of those found, and those that may be it as well."""
        if not found:
            return otherwise, ()
        best = min(found, key=lambda one: float(one.cost.sum()))
        simpler = [model for model in found if PLANES not in numbered(model.reading) and margin(model, best) < SURE]
        if PLANES in numbered(best.reading) and simpler:  # it has a number more
            best = min(simpler, key=lambda one: float(one.cost.sum()))
        return best, tuple(model for model in found if model is not best and self._is_rival(model, best))

    def _is_rival(self, other: Candidate, best: Candidate) -> bool:
        """Return whether neither the cost nor a fit of both tells two readings apart."""
        if margin(other, best) > SURE:
            return False
        names, others = (numbered(candidate.reading) for candidate in (best, other))
        if names == tuple(SCALE if name == PLANES else name for name in others):
            return False  # the other has a number more
        union = {*names, *others}
        union -= {SCALE} if PLANES in union else set()
        both = self._model(tuple(name for name in self._names if name in union))
        return not all(self._sureness(both, name) > _SECOND * SURE for name in union - {*others})

    def _besides(self, best: Candidate) -> tuple[str, ...]:
        """Return what surely differs besides, where all numbers at once fit surely better."""
        every = self._candidate(self._every)
        if every.cost.sum() > best.cost.sum():  # it did not find there
            every = self._candidate(self._fit_all(best.reading))
        if margin(best, every) <= SURE:
            return ()
        taken = numbered(best.reading)
        return tuple(
            name
            for name in self._names
            if name not in taken and matters(self.search, name, every.reading) and self._sureness(every, name) > SURE
        )

    def _gains(self, nothing: Candidate, one: Candidate, needed: float) -> bool:
        return margin(nothing, one) > (-_NO_WORSE if not nothing.changes else needed / 4)

    def _is_known(self, one: Candidate, needed: float) -> bool:
        names = numbered(one.reading)
        return bool(names) and all(
            matters(self.search, name, one.reading) and self._sureness(one, name) > needed for name in names
        )

    def _sureness(self, one: Candidate, name: str) -> float:
        """Return by how many standard errors a convention is not as stated."""
        assert one.fitted is not None
        error = dict(zip(one.fitted.names, one.fitted.error, strict=True))
        each = [self._off(one.reading, number) / float(error[number]) for number in _DECIDES[FITTED[name]]]
        return min(each) if name == CENTRE and is_half_a_pixel(one.reading) else max(each)

    def _off(self, reading: Reading, number: str) -> float:
        now, then = (getattr(which, number) for which in (reading, self.base))
        return abs(math.log(now / then)) if number in LOGARITHMS else abs(now - then)

    def _model(self, names: tuple[str, ...]) -> Candidate:
        """Return the reading in which these conventions differ, from the best known start."""
        if names not in self._models:
            starts = [seed for seed in self._seeds if set(numbered(seed)) <= set(names)]
            starts += [one.reading for tried, one in self._models.items() if set(tried) <= set(names)]
            start = min(dict.fromkeys(starts), key=lambda one: self._candidate(fixed(one)).cost.sum())
            self._models[names] = self._candidate(self._fit(start, names))
        return self._models[names]

    def _fit_all(self, start: Reading) -> Fitted:
        return self._fit(start, [name for name in self._names if name != SCALE])

    def _fit(self, start: Reading, names: Sequence[str]) -> Fitted:
        numbers = dict.fromkeys(itertools.chain(self._always, *(FITTED[name] for name in names)))
        return self.search.fitted(start, tuple(numbers)) if numbers else fixed(start)

    def _candidate(self, fitted: Fitted) -> Candidate:
        return self.search.candidate(fitted.reading, self.noise, len(differences(fitted.reading)), fitted)


def fixed(reading: Reading) -> Fitted:
    """Return a reading of which nothing is fitted."""
    return Fitted(reading, (), np.empty(0), np.empty(0))
