"""From candidates to an answer: which conventions differ from what is stated, and how sure."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence

import attrs
import numpy as np

from .conventions import (
    CENTRE,
    ENCODING,
    PIXEL,
    PLANES,
    RAY,
    ROWS,
    SCALE,
    TIME,
    WIDTH,
    differences,
    is_half_a_pixel,
)
from .frame_reading import Reading
from .overlap import ALONG, FACTOR, LATE, OFFSET, PIXEL_X, PIXEL_Y, WIDE_X, WIDE_Y, Fitted, Noise
from .search import SURE, Candidate, Search, margin

CLOSE = 0.05  # share of the depth within which two depths agree
# Of the depths agree: what is left are small numbers; one convention explains the frames.
WELL, _ENOUGH = 0.85, 0.6
ALIKE = 0.3  # correlation of the brightness: frames with less do not agree
_KEPT = 6  # readings of the coarse pictures that are looked at closely
_NEAR_BEST = 0.7  # of the best agreement: what has less is not looked at
_AS_GOOD = 0.8  # of the best agreement: what has less is not as good
_SECOND = 4  # times as sure: a second number may stand in for what the first leaves
_NO_WORSE = 2.0  # standard errors of the cost, which says less than the fitted number itself
# Below these a number is as stated.
_SCALE, _OFFSET, _LATE, _WIDTH = 0.05, 0.05, 0.1, 0.015
_CENTRE = 0.01  # of the width, and a pixel at least
_MOST = 0.95  # of the inverse depth of what is farthest: a far plane beyond it moves it by less
_OF_NUMBER = {FACTOR: SCALE, OFFSET: PLANES, ALONG: RAY, LATE: TIME}
# Of these one number may be right; the others are of one kind, or none of it.
_EITHER = {PIXEL_X: CENTRE, PIXEL_Y: CENTRE, WIDE_X: WIDTH, WIDE_Y: WIDTH}


@attrs.frozen(eq=False)
class Decision:
    """The best reading, and the others that were close."""

    search: Search
    noise: Noise
    best: Candidate
    others: tuple[Candidate, ...]


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
    """Return the best reading of the frames."""
    plain = Reading()
    found = [plain, *search.discrete(plain)]
    well = agreement(search, search.best(found)) >= WELL
    found += _best_of(search, search.usual_numbers(plain)[:1])
    if not well:
        numbers = _best_of(search, search.numbers(plain))
        found += numbers
        if not explains(search, search.best(found)):
            encoded = [reading for reading in numbers if ENCODING in differences(reading)]
            found += [search.fitted(reading, (FACTOR, OFFSET)).reading for reading in encoded]
        if not explains(search, search.best(found)):
            found += _two(search, plain)
    lens = [search.best(way) for way in search.lens(plain)]
    close = _close(search, [*found, *lens, *search.late(plain)])
    noise = Noise.of(search.fine.residuals(close[0].reading))
    candidates = [
        search.candidate(fitted.reading, noise, len(differences(fitted.reading)), fitted)
        for fitted in (*close, *([] if any(candidate.reading == plain for candidate in close) else [_fixed(plain)]))
    ]
    leader = _simplest(search, candidates)
    for _ in range(2):
        needed = _SECOND * SURE if leader.changes else SURE
        finer = [reading for reading in _finer(search, leader, noise) if _is_finer(reading, leader, needed)]
        if not finer:
            break
        candidates += finer
        leader = min(finer, key=lambda one: float(one.cost.sum()))
    if leader.changes > 1:
        leader = _simplest(search, [candidate for candidate in candidates if candidate.changes])
    return Decision(search, noise, leader, tuple(candidate for candidate in candidates if candidate is not leader))


def _fixed(reading: Reading) -> Fitted:
    return Fitted(reading, (), np.empty(0), np.empty(0))


def _close(search: Search, found: Sequence[Reading]) -> list[Fitted]:
    """Return the few best readings of the coarse pictures, numbers fitted."""
    kept: list[Fitted] = []
    least = 0.0
    for reading in sorted(dict.fromkeys(found), key=search.score, reverse=True):
        if len(kept) == _KEPT or search.score(reading) < least:
            break
        names = [FACTOR] if {ENCODING, PLANES, SCALE} & set(differences(reading)) else []
        names += [OFFSET] if reading.offset or reading.end else []
        names += [LATE] if reading.late_s else []
        names += [WIDE_X, WIDE_Y] if reading.wide_x or reading.wide_y else []
        names += [PIXEL_X, PIXEL_Y] if reading.pixel_x or reading.pixel_y else []
        fitted = search.fitted(reading, names) if names else _fixed(reading)
        if _possible(search, fitted.reading):
            least = least or _NEAR_BEST * search.score(reading)
            kept.append(fitted)
    return kept


def _possible(search: Search, reading: Reading) -> bool:
    """Return whether depth stays in front of the eye, and differs from what is stated."""
    known = differences(reading)
    return all(_matters(search, name, Reading(), reading) for name in (PLANES, SCALE, WIDTH, CENTRE) if name in known)


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
    for single in [*singles, *found]:
        both += [two for two in search.discrete(single) if len(differences(two)) == 2]
        both += _best_of(search, search.usual_numbers(single))
    return both


def _is_finer(one: Candidate, leader: Candidate, needed: float) -> bool:
    """Return whether the new number is known to differ, and frames agree better with it."""
    assert one.fitted is not None
    before = {CENTRE if name == PIXEL else name for name in differences(leader.reading)}
    before |= {SCALE, PLANES} if ENCODING in before else {SCALE} if PLANES in before else set()
    sure = np.abs(one.fitted.change) > needed * one.fitted.error
    known = dict(zip(one.fitted.names, sure.tolist(), strict=True))
    new = {name: is_known for name, is_known in known.items() if {**_OF_NUMBER, **_EITHER}[name] not in before}
    either = [is_known for name, is_known in new.items() if name in _EITHER]
    is_sure = all(is_known for name, is_known in new.items() if name not in _EITHER)
    if either:
        is_sure = is_sure and (all(either) if PIXEL in differences(one.reading) else any(either))
    least = -_NO_WORSE if not leader.changes else needed / 4
    return is_sure and margin(leader, one) > least


def _finer(search: Search, leader: Candidate, noise: Noise) -> Iterator[Candidate]:
    """Yield readings with one more number that differs enough to be named."""
    start, known = leader.reading, differences(leader.reading)
    groups: dict[str, tuple[str, ...]] = {
        RAY: (ALONG,),
        CENTRE: (PIXEL_X, PIXEL_Y),
        WIDTH: (WIDE_X, WIDE_Y),
        TIME: (LATE,),
    }
    if not {ENCODING, PLANES} & set(known):
        groups |= {SCALE: (FACTOR,), PLANES: (FACTOR, OFFSET)}
    for name, numbers in groups.items():
        if name in known or (name == CENTRE and PIXEL in known) or not set(numbers) <= set(search.steps(start)):
            continue
        before: list[tuple[str, ...]] = (
            [(FACTOR, OFFSET)] if {ENCODING, PLANES} & set(known) else [(FACTOR,)] if SCALE in known else []
        )
        before += [(WIDE_X, WIDE_Y)] if WIDTH in known else []
        before += [(PIXEL_X, PIXEL_Y)] if {PIXEL, CENTRE} & set(known) else []
        extra = tuple(itertools.chain(*before, numbers))
        # A scale may be far off, where no slope leads.
        near = search.best([start, *_best_of(search, search.usual_numbers(start)[:1])]) if name == SCALE else start
        fitted = search.fitted(near, tuple(dict.fromkeys(extra)))
        if near != start:
            fitted = attrs.evolve(fitted, change=fitted.change + math.log(near.factor / start.factor))
        if _matters(search, name, start, fitted.reading):
            yield search.candidate(fitted.reading, noise, len(differences(fitted.reading)), fitted)


def _matters(search: Search, name: str, start: Reading, found: Reading) -> bool:
    """Return whether a number differs so much that it has a name."""
    if name == RAY:
        return found.along - start.along > 0.5
    if name == CENTRE:
        least = max(1.0, _CENTRE * search.stated.frames[0].depth.shape[1])
        return is_half_a_pixel(found) or math.hypot(found.pixel_x, found.pixel_y) > least
    if name == WIDTH:
        return max(abs(found.wide_x), abs(found.wide_y)) > _WIDTH
    if name == TIME:
        assert search.stated.interval_s is not None
        return abs(found.late_s) > _LATE * search.stated.interval_s
    if name == PLANES:
        return _OFFSET * search.farthest(found) < abs(found.offset) and found.offset > -_MOST * search.farthest(found)
    return abs(math.log(found.factor / start.factor)) > _SCALE
