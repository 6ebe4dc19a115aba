"""From candidates to an answer: which conventions differ from what is stated, and how sure."""

from __future__ import annotations

from collections.abc import Sequence

import attrs
import numpy as np

from .conventions import CENTRE, ENCODING, FOCAL, PLANES, ROWS, SCALE, TIME, differences
from .frame_reading import Reading
from .numbers import FITTED, Numbers, NumberSearch, fixed, matters, numbered, without_numbers
from .overlap import FACTOR, OFFSET, Fitted, Noise
from .search import SURE, Candidate, Search, margin

CLOSE = 0.05  # share of the depth within which two depths agree
# Of the depths agree: what is left are small numbers; one convention explains the frames.
WELL, _ENOUGH = 0.85, 0.6
ALIKE = 0.3  # correlation of the brightness: frames with less do not agree
_MOST_CHANGES = 2  # that are named
_KEPT = 6  # readings of the coarse pictures that are looked at closely
_NEAR_BEST = 0.7  # of the best agreement: what has less is not looked at
_AS_GOOD = 0.8  # of the best agreement: what has less is not as good
_LOOSE = (FOCAL, CENTRE, TIME)  # tried on a wide grid


@attrs.frozen(eq=False)
class Decision:
    """What is wrong, or that it cannot be told: headline, findings and code are written from it."""

    search: Search
    noise: Noise
    best: Candidate
    # Readings with as few other changes under which the frames agree as well.
    rivals: tuple[Candidate, ...] = ()
    # Conventions of which one or more differ besides, where no reading of them was found.
    besides: tuple[str, ...] = ()

    @property
    def is_told(self) -> bool:
        """Whether the best reading is the only one that explains the frames."""
        return not self.rivals and not self.besides

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
    known = found.seen & ~np.isnan(found.depth)
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
        numbers = _best_of(search, search.numbers(plain))
        found += numbers
        if not explains(search, search.best(found)):
            encoded = [reading for reading in numbers if ENCODING in differences(reading)]
            found += [search.fitted(reading, (FACTOR, OFFSET)).reading for reading in encoded]
        if not explains(search, search.best(found)):
            found += _two(search, plain)
    close = _close(search, found)
    readings = list(dict.fromkeys([*(fitted.reading for fitted in close), plain]))
    noise = Noise.of(search.fine.residuals(readings[0]))
    found_numbers = NumberSearch(search, _simplest(search, _candidates(search, readings, noise)), readings).found()
    return _decided(search, _stepped(search, found_numbers, readings), readings)


def _stepped(search: Search, found: Numbers, readings: Sequence[Reading]) -> Numbers:
    """Return the same, or with one more convention without a number where that is surely better."""
    steps = _candidates(search, list(search.discrete(found.best.reading)), found.noise)
    better = min(steps, key=lambda one: float(one.cost.sum()))
    if margin(found.best, better) <= SURE:
        return found
    return NumberSearch(search, better, [better.reading, *readings]).found()


def _decided(search: Search, found: Numbers, readings: Sequence[Reading]) -> Decision:
    """Return the decision between what the numbers explain, and other readings that were close."""
    best, rivals, besides = found.best, found.rivals, found.besides
    others = _candidates(search, readings, found.noise)
    if best.changes > 1:
        best = _simplest(search, [best, *(other for other in others if other.changes)])
        rivals, besides = (rivals, besides) if best is found.best else ((), ())
    if best.changes:
        most = agreement(search, best.reading)
        as_good = (
            other
            for other in others
            if 0 < other.changes <= best.changes
            and without_numbers(other.reading) != without_numbers(best.reading)
            and differences(other.reading) != differences(best.reading)
            and margin(other, best) < SURE
            and agreement(search, other.reading) >= _AS_GOOD * most
        )
        rivals += tuple(as_good)
    if best.changes > _MOST_CHANGES:  # with so many, others may do as well
        besides = tuple(dict.fromkeys((*differences(best.reading), *besides)))
    return Decision(search, found.noise, best, rivals, besides)


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
        fitted = search.fitted(reading, names) if names else fixed(reading)
        if all(matters(search, name, fitted.reading) for name in numbered(fitted.reading)):
            least = least or _NEAR_BEST * search.score(reading)
            kept.append(fitted)
    return kept


def _numbers_of(reading: Reading) -> list[str]:
    names = [FACTOR] if {ENCODING, PLANES, SCALE} & set(differences(reading)) else []
    names += [OFFSET] if reading.offset or reading.end else []
    return [*names, *(number for name in numbered(reading) if name in _LOOSE for number in FITTED[name])]


def _simplest(search: Search, candidates: Sequence[Candidate]) -> Candidate:
    """Return the best one, or one of fewer changes that is not surely worse.

    Nor is one under which more depths agree, and pictures are more alike: the cost of numbers that
    hardly differ is small under any reading.
    """
    best = min(candidates, key=lambda one: float(one.cost.sum()))
    most, alike = agreement(search, best.reading), likeness(search, best.reading)

    def is_as_good(one: Candidate) -> bool:
        share = agreement(search, one.reading)
        if margin(one, best) < SURE and share >= _AS_GOOD * most:
            return True
        return share >= most and likeness(search, one.reading) >= alike

    as_good = [candidate for candidate in candidates if is_as_good(candidate)]
    return min(as_good, key=lambda one: (one.changes, float(one.cost.sum())))


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
