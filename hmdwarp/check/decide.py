"""From candidates to an answer: which conventions differ from what is stated, and how sure."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence

import attrs
import numpy as np

from .conventions import CENTRE, ENCODING, FOCAL, PIXEL, PLANES, RAY, ROWS, SCALE, TIME, differences, restored
from .faults import EXPLAINED, explained, standing
from .overlap import ALONG, FACTOR, LATE, LOGARITHMS, OFFSET, PIXEL_X, PIXEL_Y, WIDE, WIDE_X, WIDE_Y, Fitted, Noise
from .search import SURE, Candidate, Search, margin
from .stated_frames import Reading

CLOSE = 0.05  # share of the depth within which two depths agree
WELL, _ENOUGH = 0.85, 0.6  # of the depths agree: what is left are small numbers; one convention explains the frames
AGREE = 0.5  # share of the depths: below it, frames do not agree
ALIKE = 0.3  # correlation of the brightness: frames with less do not agree
_MOST_CHANGES = 2  # that are named
_KEPT = 6  # readings of the coarse pictures that are looked at closely
_NEAR_BEST = 0.7  # of the best agreement: what has less is not looked at
_AS_GOOD = 0.8  # of the best agreement: what has less is not as good
_LESS = 0.005  # of what is explained: an answer that explains less than what is stated is none
_LEFT = 0.2  # of what is not, as stated: what an answer may leave of a noisy sensor's frames
_LOOSE = (FOCAL, CENTRE, TIME)  # tried on a wide grid


@attrs.frozen(eq=False)
class Decision:
    """What is wrong, or that it cannot be told: headline, findings and code are written from it."""

    search: Search
    noise: Noise
    best: Candidate
    rivals: tuple[Candidate, ...] = ()  # readings with as few other changes under which the frames agree as well
    # Conventions of which one or more differ besides, where no reading of them was found.
    besides: tuple[str, ...] = ()
    faults: tuple[str, ...] = ()  # faults that are no convention and explain as much, or what the best reading leaves
    # Shares of the depths that the best reading explains, and what is stated.
    explained: tuple[float, float] = (1.0, 1.0)

    @property
    def is_told(self) -> bool:
        """Whether the best reading is the only one that explains the frames, and nearly all."""
        share, stated = self.explained
        enough = not self.best.changes or share >= max(EXPLAINED, stated - _LESS) or 1 - share < _LEFT * (1 - stated)
        return not self.rivals and not self.besides and not self.faults and enough

    @property
    def causes(self) -> tuple[tuple[str, ...], ...]:
        """The conventions that differ: of the best reading first, then of its rivals."""
        return tuple(dict.fromkeys(differences(possible.reading) for possible in (self.best, *self.rivals)))


def likeness(search: Search, reading: Reading) -> float:
    """Return the correlation of the brightness where depths agree, 0 if there is none."""
    found = search.middle.residuals(reading)
    with np.errstate(invalid="ignore"):
        known = found.seen & (np.abs(found.depth) < CLOSE)
    here, there = found.brightness[known], (found.brightness + found.colour)[known]
    return float(np.corrcoef(here, there)[0, 1]) if min(here.std(), there.std(), len(here)) > 0 else 0.0


def agreement(search: Search, reading: Reading) -> float:
    """Return the share of the points seen in both frames whose depths agree."""
    # Counted from infinity, as depths are: numbers that hardly differ agree with anything.
    infinity = reading.end - reading.offset / reading.factor
    found = search.coarse.residuals(attrs.evolve(reading, end=infinity, offset=0.0) if not reading.along else reading)
    known = found.seen & ~np.isnan(found.depth) & ~found.sky
    return float((np.abs(found.depth[known]) < CLOSE).mean()) if known.any() else 0.0


def explains(search: Search, reading: Reading) -> bool:
    """Return whether a reading leaves small numbers alone to be found."""
    share = agreement(search, reading)
    return share >= WELL or (share >= _ENOUGH and likeness(search, reading) >= ALIKE)


def decide(search: Search) -> Decision:
    """Return the best reading of the frames, and whether others fit as well."""
    plain = Reading()
    found = [plain, *search.discrete(plain)]
    well = agreement(search, search.best(found)) >= WELL
    found += _best_of(search, search.usual_numbers(plain)[:1])
    found += [search.best(way) for way in (*search.cameras(plain), search.late(plain)) if way]
    if not well:
        others = _best_of(search, search.numbers(plain))
        found += others
        if not explains(search, search.best(found)):
            encoded = [reading for reading in others if ENCODING in differences(reading)]
            found += [search.fitted(reading, (FACTOR, OFFSET)).reading for reading in encoded]
        if not explains(search, search.best(found)):
            found += _two(search, plain)
    close = _close(search, found)
    readings = list(dict.fromkeys([*(fitted.reading for fitted in close), plain]))
    noise = Noise.of(search.fine.residuals(readings[0]))
    numbers = NumberSearch(search, _simplest(search, _candidates(search, readings, noise)), readings).found()
    best = numbers.best
    # One more convention without a number, where that is surely better.
    steps = _candidates(search, list(search.discrete(best.reading)), numbers.noise)
    better = min(steps, key=lambda one: one.total)
    if margin(best, better) > SURE and _simplest(search, [best, better]) is not best:
        numbers = NumberSearch(search, better, [better.reading, *readings]).found()
    return _decided(search, numbers, readings)


def _decided(search: Search, found: Numbers, readings: Sequence[Reading]) -> Decision:
    """Return the decision between what the numbers explain, and other readings that were close."""
    best, rivals, besides = found.best, found.rivals, found.besides
    others = _candidates(search, readings, found.noise)
    if best.changes > 1:
        best = _simplest(search, [best, *(other for other in others if other.changes)])
        rivals, besides = (rivals, besides) if best is found.best else ((), ())
    if best.changes:
        most = agreement(search, best.reading)
        rivals += tuple(
            other
            for other in others
            if 0 < other.changes <= best.changes
            and without_numbers(other.reading) != without_numbers(best.reading)
            and differences(other.reading) != differences(best.reading)
            and margin(other, best) < SURE
            and agreement(search, other.reading) >= _AS_GOOD * most
        )
    if best.changes > _MOST_CHANGES:  # with so many, others may do as well
        besides = tuple(dict.fromkeys((*differences(best.reading), *besides)))
    shares = explained(search, best.reading), explained(search, Reading())
    faults: tuple[str, ...] = ()
    if agreement(search, best.reading) >= AGREE:
        own, base = _numbers_of(best.reading), without_numbers(best.reading)
        faults = standing(search, found.noise, best, own, base)
    return Decision(search, found.noise, best, rivals, besides, faults, shares)


def _candidates(search: Search, readings: Sequence[Reading], noise: Noise) -> list[Candidate]:
    return [search.candidate(reading, noise, len(differences(reading))) for reading in readings]


def _close(search: Search, found: Sequence[Reading]) -> list[Fitted]:
    """Return the few best readings of the coarse pictures, numbers fitted."""
    kept: list[Fitted] = []
    least = 0.0
    for reading in sorted(dict.fromkeys(found), key=search.score, reverse=True):
        if len(kept) == _KEPT or search.score(reading) < least:
            break
        names = _numbers_of(reading)
        fitted = search.fitted(reading, names) if names else Fitted(reading)
        if all(matters(search, name, fitted.reading) for name in numbered(fitted.reading)):
            least = least or _NEAR_BEST * search.score(reading)
            kept.append(fitted)
    return kept


def _numbers_of(reading: Reading) -> tuple[str, ...]:
    names = [FACTOR] if {ENCODING, PLANES, SCALE} & set(differences(reading)) else []
    names += [OFFSET] if reading.offset or reading.end else []
    return (*names, *(number for name in numbered(reading) if name in _LOOSE for number in FITTED[name]))


def _simplest(search: Search, candidates: Sequence[Candidate]) -> Candidate:
    """Return the best one, or one of fewer changes that is not surely worse.

    Nor is one under which more depths agree, and pictures are more alike: the cost of numbers that
    hardly differ, and of one sky on another, is small under any reading.
    """
    best = min(candidates, key=lambda one: one.total)
    most, alike = agreement(search, best.reading), likeness(search, best.reading)
    if alike < ALIKE:
        better = [
            one
            for one in candidates
            if agreement(search, one.reading) >= most and likeness(search, one.reading) >= ALIKE
        ]
        if better:
            return _simplest(search, better)

    as_good = [
        one
        for one, share in ((one, agreement(search, one.reading)) for one in candidates)
        if (margin(one, best) < SURE and share >= _AS_GOOD * most)
        or (share >= most and likeness(search, one.reading) >= alike)
    ]
    return min(as_good, key=lambda one: (one.changes, one.total))


def _best_of(search: Search, ways: Sequence[Sequence[Reading]]) -> list[Reading]:
    return [search.sharpened(search.best(way)) for way in ways if way]


def _two(search: Search, plain: Reading) -> list[Reading]:
    """Return readings of two conventions that differ."""
    singles = [reading for reading in search.discrete(plain) if ROWS not in differences(reading)]
    found = list(search.rows(plain))
    both: list[Reading] = []
    cameras = [search.best(way) for way in search.cameras(plain)]
    for single in [*singles, *found, *cameras]:
        both += [two for two in search.discrete(single) if len(differences(two)) == 2]
        both += _best_of(search, search.usual_numbers(single))
        both += [search.best(way) for way in search.cameras(single)]
    return both


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
        return found.is_half_a_pixel or max(abs(found.pixel_x), abs(found.pixel_y)) > least
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
        gain = -_NO_WORSE if not nothing.changes else needed / 4
        singles = [one for one in self._of(1) if self._is_known(one, needed) and margin(nothing, one) > gain]
        best, rivals = self._least(nothing, singles)
        besides = self._besides(best)
        if besides and not nothing.changes:
            pairs = [model for model in self._of(2) if self._is_known(model, SURE) and margin(best, model) > SURE]
            best, rivals = self._least(best, pairs) if pairs else (best, rivals)
            besides = self._besides(best) if pairs else besides
        return Numbers(self._square(best), rivals, besides, self.noise)

    def _square(self, best: Candidate) -> Candidate:
        """Return the reading with one factor for both focal lengths, unless two are surely better.

        Heads that never look up or down leave one of the two undetermined.
        """
        if FOCAL not in numbered(best.reading) or best.fitted is None:
            return best
        names = (*(name for name in best.fitted.names if name not in FITTED[FOCAL]), WIDE)
        starts = (
            attrs.evolve(best.reading, wide_x=wide, wide_y=wide) for wide in (best.reading.wide_x, best.reading.wide_y)
        )
        models = [self._candidate(self.search.fitted(start, names)) for start in starts]
        one = min(models, key=lambda one: one.total)
        return one if margin(one, best) <= SURE else best

    def _of(self, count: int) -> Iterator[Candidate]:
        for names in itertools.combinations(self._names, count):
            if not {SCALE, PLANES} <= set(names):
                yield self._model(names)

    def _least(self, otherwise: Candidate, found: Sequence[Candidate]) -> tuple[Candidate, tuple[Candidate, ...]]:
        """Return the best of those found, and those that may be it as well."""
        if not found:
            return otherwise, ()
        best = min(found, key=lambda one: one.total)
        simpler = [model for model in found if PLANES not in numbered(model.reading) and margin(model, best) < SURE]
        if PLANES in numbered(best.reading) and simpler:  # it has a number more
            best = min(simpler, key=lambda one: one.total)
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
        if every.total > best.total:  # it did not find there
            every = self._candidate(self._fit_all(best.reading))
        if margin(best, every) <= SURE:
            return ()
        taken = numbered(best.reading)
        return tuple(
            name
            for name in self._names
            if name not in taken and matters(self.search, name, every.reading) and self._sureness(every, name) > SURE
        )

    def _is_known(self, one: Candidate, needed: float) -> bool:
        names = numbered(one.reading)
        return bool(names) and all(
            matters(self.search, name, one.reading) and self._sureness(one, name) > needed for name in names
        )

    def _sureness(self, one: Candidate, name: str) -> float:
        """Return by how many standard errors a convention is not as stated."""
        assert one.fitted is not None
        error = dict(zip(one.fitted.names, one.fitted.error, strict=True))
        each = []
        for number in _DECIDES[FITTED[name]]:
            now, then = (getattr(which, number) for which in (one.reading, self.base))
            off = math.log(now / then) if number in LOGARITHMS else now - then
            each.append(float(abs(off) / error[number]))
        return min(each) if name == CENTRE and one.reading.is_half_a_pixel else max(each)

    def _model(self, names: tuple[str, ...]) -> Candidate:
        """Return the reading in which these conventions differ, from the best known start."""
        if names not in self._models:
            starts = [seed for seed in self._seeds if set(numbered(seed)) <= set(names)]
            starts += [one.reading for tried, one in self._models.items() if set(tried) <= set(names)]
            start = min(dict.fromkeys(starts), key=lambda one: self._candidate(Fitted(one)).total)
            self._models[names] = self._candidate(self._fit(start, names))
        return self._models[names]

    def _fit_all(self, start: Reading) -> Fitted:
        return self._fit(start, [name for name in self._names if name != SCALE])

    def _fit(self, start: Reading, names: Sequence[str]) -> Fitted:
        numbers = dict.fromkeys(itertools.chain(self._always, *(FITTED[name] for name in names)))
        return self.search.fitted(start, tuple(numbers)) if numbers else Fitted(start)

    def _candidate(self, fitted: Fitted) -> Candidate:
        return self.search.candidate(fitted.reading, self.noise, len(differences(fitted.reading)), fitted)
