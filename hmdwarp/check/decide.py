"""From candidates to an answer: which conventions differ, how sure, and code that reads them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import Any

import attrs
import numpy as np

from ..base import listed
from . import conventions
from .conventions import CONVENTIONS, Answer, Finding, differences, restored, value
from .search import (
    DEPTH_SHIFT,
    LOGARITHMS,
    SURE,
    TURN,
    WIDE,
    Candidate,
    Fitted,
    Noise,
    Overlap,
    Search,
    cost,
    margin,
    noise_of,
    standard_errors,
)
from .stated_frames import Array, Reading, Stated

PLAIN = Reading()  # as stated
CLOSE = 0.05  # share of the depth within which two depths agree
_WELL, _ENOUGH = 0.85, 0.6  # of the depths agree: what is left are small numbers; one convention explains the frames
AGREE = 0.5  # share of the depths: below it, frames do not agree
ALIKE = 0.3  # correlation of the brightness: frames with less do not agree
_MOST_CHANGES = 2  # that are named
_KEPT = 6  # readings of the coarse pictures that are looked at closely
_NEAR_BEST = 0.7  # of the best agreement: what has less is not looked at
_AS_GOOD = 0.8  # of the best agreement: what has less is not as good
_LESS = 0.005  # of what is explained: an answer that explains less than what is stated is none
_LEFT = 0.2  # of what is not, as stated: what an answer may leave of a noisy sensor's frames
_LOOSE = ("focal", "centre", "time")  # tried on a wide grid


def likeness(search: Search, reading: Reading) -> float:
    """Return the correlation of the brightness where depths agree, 0 if there is none."""
    found = search.middle.residuals(reading)
    with np.errstate(invalid="ignore"):
        known = found.seen & (np.abs(found.depth) < CLOSE)
    here, there = found.brightness[known], (found.brightness + found.colour)[known]
    return float(np.corrcoef(here, there)[0, 1]) if min(here.std(), there.std(), len(here)) > 0 else 0.0


def agreement(search: Search, reading: Reading) -> float:
    """Return the share of the points seen in both frames whose depths agree."""
    known = _from_infinity(search.coarse, reading)
    return float((np.abs(known) < CLOSE).mean()) if known.size else 0.0


def _from_infinity(overlap: Overlap, reading: Reading) -> Array:
    """Return how depths in view differ, counted from infinity: else what hardly differs agrees."""
    infinity = reading.end - reading.offset / reading.factor
    found = overlap.residuals(attrs.evolve(reading, end=infinity, offset=0.0) if not reading.along else reading)
    return found.depth[found.seen & ~np.isnan(found.depth) & ~found.sky]


def explains(search: Search, reading: Reading) -> bool:
    """Return whether a reading leaves small numbers alone to be found."""
    share = agreement(search, reading)
    return share >= _WELL or (share >= _ENOUGH and likeness(search, reading) >= ALIKE)


def check(stated: Stated) -> Answer:
    """Return under which conventions frames agree.

    Parameters
    ----------
    stated : Stated
        Two or more frames, as `read_stated` reads them.

    Returns
    -------
    Answer
        The verdict, what is found of each convention, and the code that reads such frames right.
    """
    search, plain = Search(stated), PLAIN
    tried = [plain, *search.discrete(plain)]
    well = agreement(search, search.best(tried)) >= _WELL
    tried += _best_of(search, search.numbers(plain, usual=True)[:1])
    tried += [search.best(way) for way in (*search.cameras(plain), search.late(plain)) if way]
    if not well:
        others = _best_of(search, search.numbers(plain))
        tried += others
        if not explains(search, search.best(tried)):
            encoded = [reading for reading in others if "encoding" in differences(reading)]
            tried += [search.fitted(reading, ("factor", "offset"))[0] for reading in encoded]
        if not explains(search, search.best(tried)):
            tried += _two(search, plain)
    readings = list(dict.fromkeys([*_close(search, tried), plain]))
    noise = noise_of(search.fine.residuals(readings[0]))
    numbers = _NumberSearch(search, _simplest(search, [search.candidate(noise, one) for one in readings]), readings)
    best, rivals, besides = numbers.found()
    # One more convention without a number, where that is surely better.
    steps = [search.candidate(numbers.noise, one) for one in search.discrete(best.reading)]
    better = min(steps, key=lambda one: one.total)
    if margin(best, better) > SURE and _simplest(search, [best, better]) is not best:
        numbers = _NumberSearch(search, better, [better.reading, *readings])
        best, rivals, besides = numbers.found()
    # Between what the numbers explain, and other readings that were close.
    close = [search.candidate(numbers.noise, one) for one in readings]
    if best.changes > 1:
        simplest = _simplest(search, [best, *(other for other in close if other.changes)])
        best, rivals, besides = (best, rivals, besides) if simplest is best else (simplest, (), ())
    if best.changes:
        most = agreement(search, best.reading)
        rivals += tuple(
            other
            for other in close
            if 0 < other.changes <= best.changes
            and _without_numbers(other.reading) != _without_numbers(best.reading)
            and differences(other.reading) != differences(best.reading)
            and margin(other, best) < SURE
            and agreement(search, other.reading) >= _AS_GOOD * most
        )
    if best.changes > _MOST_CHANGES:  # with so many, others may do as well
        besides = tuple(dict.fromkeys((*differences(best.reading), *besides)))
    return _answer(search, best, rivals, besides, numbers.noise)


def _close(search: Search, found: Sequence[Reading]) -> list[Reading]:
    """Return the few best readings of the coarse pictures, numbers fitted."""
    kept: list[Reading] = []
    least = 0.0
    for reading in sorted(dict.fromkeys(found), key=search.score, reverse=True):
        if len(kept) == _KEPT or search.score(reading) < least:
            break
        fitted = search.fitted(reading, _numbers_of(reading))[0]
        if all(matters(search, name, fitted) for name in numbered(fitted)):
            least = least or _NEAR_BEST * search.score(reading)
            kept.append(fitted)
    return kept


def _numbers_of(reading: Reading) -> tuple[str, ...]:
    names = ["factor"] if {"encoding", "planes", "scale"} & set(differences(reading)) else []
    names += ["offset"] if reading.offset or reading.end else []
    return (*names, *(number for name in numbered(reading) if name in _LOOSE for number in FITTED[name]))


def _simplest(search: Search, candidates: Sequence[Candidate]) -> Candidate:
    """Return the best one, or one of fewer changes that is not surely worse."""
    # Nor is one under which more depths agree, and pictures are more alike: numbers that hardly
    # differ, and one sky on another, cost little under any reading.
    best = min(candidates, key=lambda one: one.total)
    most, alike = agreement(search, best.reading), likeness(search, best.reading)
    shares = [(one, agreement(search, one.reading)) for one in candidates]
    if alike < ALIKE:
        better = [one for one, share in shares if share >= most and likeness(search, one.reading) >= ALIKE]
        if better:
            return _simplest(search, better)
    as_good = [
        one
        for one, share in shares
        if (margin(one, best) < SURE and share >= _AS_GOOD * most)
        or (share >= most and likeness(search, one.reading) >= alike)
    ]
    return min(as_good, key=lambda one: (one.changes, one.total))


def _best_of(search: Search, ways: Sequence[Sequence[Reading]]) -> list[Reading]:
    return [search.sharpened(search.best(way)) for way in ways if way]


def _two(search: Search, plain: Reading) -> list[Reading]:
    """Return readings of two conventions that differ."""
    both: list[Reading] = []
    for single in [*search.discrete(plain), *(search.best(way) for way in search.cameras(plain))]:
        both += [two for two in search.discrete(single) if len(differences(two)) == 2]
        both += _best_of(search, search.numbers(single, usual=True))
        both += [search.best(way) for way in search.cameras(single)]
    return both


# What is fitted for each; half a pixel is a principal point too.
FITTED = {name: one.numbers for name, one in CONVENTIONS.items() if one.numbers and name != "pixel"}
_SECOND = 4  # times as sure: a number may stand in for what another convention leaves
_NO_WORSE = 2.0  # standard errors of the cost, which says less than the fitted number itself
_CENTRE = 0.005  # of the width: a principal point that is off by less is as stated
_MOST = 0.95  # of the inverse depth of what is farthest: a far plane beyond it moves it by less


def numbered(reading: Reading) -> tuple[str, ...]:
    """Return the keys of FITTED in which a reading differs from what is stated."""
    return tuple("centre" if name == "pixel" else name for name in differences(reading) if name in (*FITTED, "pixel"))


def _without_numbers(reading: Reading) -> Reading:
    """Return the reading with the conventions of FITTED as stated."""
    while names := numbered(reading):  # below other planes there may be a scale
        reading = restored(reading, names[0])
    return reading


def _off(reading: Reading, number: str, base: Reading = PLAIN) -> float:
    """Return by how much a number is not that of the base: of LOGARITHMS, by which."""
    now, then = (np.asarray(getattr(which, number) or 0.0) for which in (reading, base))
    return float(np.abs(np.log(np.abs(now / then)) if number in LOGARITHMS else now - then).max())


def matters(search: Search, name: str, found: Reading) -> bool:
    """Return whether a number differs so much from what is stated that it has a name."""
    least = CONVENTIONS[name].least
    if name == "planes":
        farthest = search.farthest(found)
        return least * farthest < abs(found.offset) and found.offset > -_MOST * farthest
    if name == "centre":
        least = 0.0 if found.is_half_a_pixel else max(least, _CENTRE * search.stated.frames[0].depth.shape[1])
    if name == "time":
        least *= search.stated.interval_s or 0.0
    return max(_off(found, number) for number in FITTED[name]) > least


class _NumberSearch:
    """Readings that differ from a leader in its numbers alone, each fitted to the fine pictures."""

    def __init__(self, search: Search, leader: Candidate, seeds: Sequence[Reading]) -> None:
        self.search, self.base = search, _without_numbers(leader.reading)
        self._always = ("factor", "offset") if "encoding" in differences(self.base) else ()
        known = search.steps(self.base)
        self._names = [
            name
            for name, numbers in FITTED.items()
            if set(numbers) <= set(known) and not (self._always and name in ("scale", "planes"))
        ]
        self._seeds = [self.base, *(seed for seed in seeds if _without_numbers(seed) == self.base)]
        if differences(self.base):
            ways = (*search.cameras(self.base), search.late(self.base))
            self._seeds += [search.best(way) for way in ways if way]
        self._models: dict[tuple[str, ...], Candidate] = {}
        self.noise = noise_of(search.fine.residuals(leader.reading))
        self._every = self._fit(leader.reading, [name for name in self._names if name != "scale"])
        self.noise = noise_of(search.fine.residuals(self._every[0]))

    def found(self) -> tuple[Candidate, tuple[Candidate, ...], tuple[str, ...]]:
        """Return the best reading of at most two numbers, those as good, and what else differs."""
        nothing = self._candidate(*self._fit(self.base, ()))
        needed = SURE if not nothing.changes else _SECOND * SURE
        gain = -_NO_WORSE if not nothing.changes else needed / 4
        best, rivals = self._least(nothing, self._surer(1, nothing, needed, gain))
        besides = self._besides(best)
        if besides and not nothing.changes:
            pairs = self._surer(2, best, SURE, SURE)
            best, rivals = self._least(best, pairs) if pairs else (best, rivals)
            besides = self._besides(best) if pairs else besides
        return self._square(best), rivals, besides

    def _square(self, best: Candidate) -> Candidate:
        """Return it with one factor for both focal lengths, unless two are surely better."""
        if "focal" not in numbered(best.reading) or not best.error:
            return best
        names = (*(name for name in best.error if name not in FITTED["focal"]), WIDE)
        wide = best.reading.wide_x, best.reading.wide_y
        starts = (attrs.evolve(best.reading, wide_x=one, wide_y=one) for one in wide)
        one = min((self._candidate(*self.search.fitted(start, names)) for start in starts), key=lambda one: one.total)
        return one if margin(one, best) <= SURE else best

    def _surer(self, count: int, than: Candidate, needed: float, gain: float) -> list[Candidate]:
        """Return the readings of so many numbers that are known, and better than one by a gain."""
        found = []
        for names in itertools.combinations(self._names, count):
            if {"scale", "planes"} <= {*names}:
                continue
            one = self._model(names)
            differ = numbered(one.reading)
            known = all(
                matters(self.search, name, one.reading) and self._sureness(one, name) > needed for name in differ
            )
            if differ and known and margin(than, one) > gain:
                found.append(one)
        return found

    def _least(self, otherwise: Candidate, found: Sequence[Candidate]) -> tuple[Candidate, tuple[Candidate, ...]]:
        """Return the best of those found, and those that may be it as well."""
        if not found:
            return otherwise, ()
        best = min(found, key=lambda one: one.total)
        simpler = [model for model in found if "planes" not in numbered(model.reading) and margin(model, best) < SURE]
        if "planes" in numbered(best.reading) and simpler:  # it has a number more
            best = min(simpler, key=lambda one: one.total)
        return best, tuple(model for model in found if model is not best and self._is_rival(model, best))

    def _is_rival(self, other: Candidate, best: Candidate) -> bool:
        """Return whether neither the cost nor a fit of both tells two readings apart."""
        if margin(other, best) > SURE:
            return False
        names, others = (numbered(candidate.reading) for candidate in (best, other))
        if names == tuple("scale" if name == "planes" else name for name in others):
            return False  # the other has a number more
        union = {*names, *others}
        union -= {"scale"} if "planes" in union else set()
        both = self._model(tuple(name for name in self._names if name in union))
        return not all(self._sureness(both, name) > _SECOND * SURE for name in union - {*others})

    def _besides(self, best: Candidate) -> tuple[str, ...]:
        """Return what surely differs besides, where all numbers at once fit surely better."""
        every = self._candidate(*self._every)
        if every.total > best.total:  # it did not find there
            every = self._candidate(*self._fit(best.reading, [name for name in self._names if name != "scale"]))
        if margin(best, every) <= SURE:
            return ()
        taken = numbered(best.reading)
        return tuple(
            name
            for name in self._names
            if name not in taken and matters(self.search, name, every.reading) and self._sureness(every, name) > SURE
        )

    def _sureness(self, one: Candidate, name: str) -> float:
        """Return by how many standard errors a convention is not as stated."""
        numbers = [number for number in FITTED[name] if number in CONVENTIONS[name].fields]
        each = [_off(one.reading, number, self.base) / one.error[number] for number in numbers]
        return min(each) if name == "centre" and one.reading.is_half_a_pixel else max(each)

    def _model(self, names: tuple[str, ...]) -> Candidate:
        """Return the reading in which these conventions differ, from the best known start."""
        if names not in self._models:
            starts = [seed for seed in self._seeds if set(numbered(seed)) <= set(names)]
            starts += [one.reading for tried, one in self._models.items() if set(tried) <= set(names)]
            start = min(dict.fromkeys(starts), key=lambda one: self._candidate(one).total)
            self._models[names] = self._candidate(*self._fit(start, names))
        return self._models[names]

    def _fit(self, start: Reading, names: Sequence[str]) -> Fitted:
        return self.search.fitted(start, (*self._always, *itertools.chain(*(FITTED[name] for name in names))))

    def _candidate(self, reading: Reading, error: dict[str, float] | None = None) -> Candidate:
        return self.search.candidate(self.noise, reading, error)


EXPLAINED = 0.98  # of the depths that nothing hides
_CUT_OFF, _AT_MOST = 0.02, 1e-3  # share of the pixels at the largest depth; how near to it they are
# What is fitted for each, and the least with a name: rad, per squared tangent, tangents, pixels.
_OF_FAULT = {
    "a turn between pose and camera": dict.fromkeys(TURN, 0.015),
    "a lens that distorts": {"bend": 0.03},
    "depth of other optics than the colour": {"depth_wide": 0.02, **dict.fromkeys(DEPTH_SHIFT, 0.75)},
    "depth of another scale in each frame": {"scales": 0.01},
}
_SHIFTS = (-0.1, -0.05, 0.0, 0.05, 0.1)  # where a fit begins; shifts of the depth in shares of the width
_STARTS = {**dict.fromkeys(TURN, (-0.12, 0.0, 0.12)), "bend": (-0.2, 0.0, 0.2), "depth_wide": (0.85, 1.0, 1.18)}
_SURELY = 14.0  # standard errors of the answer's numbers, with a fault fitted beside them


def explained(search: Search, reading: Reading) -> float:
    """Return the share of the depths on surfaces that agree, of those that nothing nearer hides."""
    known = _from_infinity(search.middle, reading) * math.copysign(1, reading.factor)
    agree, behind = int((np.abs(known) < CLOSE).sum()), int((known > CLOSE).sum())
    return agree / max(agree + behind, 1)


def standing(search: Search, noise: Noise, best: Candidate) -> list[str]:
    """Return those of FAULTS that explain what a reading leaves, or the frames as well as it."""
    width, reading, found = search.stated.frames[0].depth.shape[1], best.reading, []
    own, base = _numbers_of(reading), _without_numbers(reading)
    if not search.stated.may_be_buffer and (best.changes or explained(search, reading) < EXPLAINED):
        most = (1 - _AT_MOST) * max(float(depth.max()) for depth in search.stated.depths)
        is_cut = float(np.median([float((depth > most).mean()) for depth in search.stated.depths])) > _CUT_OFF
        found += ["depth that is cut off"] if is_cut else []
    starts = _STARTS | dict.fromkeys(DEPTH_SHIFT, tuple(at * width for at in _SHIFTS)) | {"scales": ((),)}
    for words, least in _OF_FAULT.items():
        values = itertools.product(*(starts[name] for name in least))
        tried = (attrs.evolve(base, **dict(zip(least, one, strict=True))) for one in values)
        begun = [min(tried, key=lambda one: search.candidate(noise, one).total)]
        if "depth_wide" in least:  # a shift of the depth alone looks like a principal point that is off
            begun.append(attrs.evolve(base, depth_x=-reading.pixel_x, depth_y=-reading.pixel_y))
        instead = [_fitted(search, one, tuple(least)) for one in begun]
        gains = []
        for start in (reading, *(one for one, _ in instead)):
            both = _fitted(search, start, (*least, *own))
            two = [search.fine.residuals(one) for one in (reading, both[0])]
            known = ~np.isnan(two[0].depth + two[1].depth)  # elsewhere in the picture of depth are other gaps
            before, after = (search.fine.by_block(np.where(known, cost(each, noise), np.nan)) for each in two)
            gains.append((before - after, both))
        gain, both = max(gains, key=lambda one: float(one[0].sum()))
        # A turn of a degree is half a pixel, which is the more common.
        named = {name: limit * (1 + ("pixel" in differences(reading))) for name, limit in least.items()}
        sure = [_off(both[0], name) / both[1][name] for name in own if name in both[1]]
        is_doubtful = max(sure, default=math.inf) < _SURELY and any(_has_a_name(one, named) for one in instead)
        if is_doubtful or (standard_errors(gain) > SURE and _has_a_name(both, named)):
            found.append(words)
    return found


def _has_a_name(found: Fitted, least: dict[str, float]) -> bool:
    reading, error = found
    return any(_off(reading, name) > max(most, SURE * error.get(name, 0)) for name, most in least.items())


def _fitted(search: Search, reading: Reading, names: tuple[str, ...]) -> Fitted:
    """Return the reading with these numbers as the frames have them."""
    if "scales" not in names:
        return search.fitted(search.fitted(reading, names)[0], names)
    pairs, count = search.middle.pairs, len(search.stated.frames)
    rows = np.eye(count)[pairs[:, 0]] - np.eye(count)[pairs[:, 1]]
    scales = np.zeros(count)
    for _ in range(3):
        found = search.middle.residuals(attrs.evolve(reading, scales=tuple(scales)))
        with np.errstate(invalid="ignore"):
            off = np.array([np.median(one[np.abs(one) < 1]) if (np.abs(one) < 1).any() else 0.0 for one in found.depth])
        scales -= np.linalg.lstsq(rows, off, rcond=None)[0]
    return attrs.evolve(reading, scales=tuple((scales - scales.mean()).tolist())), {}


def _answer(
    search: Search, best: Candidate, rivals: Sequence[Candidate], besides: Sequence[str], noise: Noise
) -> Answer:
    """Decide whether the best reading is told beside rivals and what differs besides, in words."""
    stated, reading, plain = search.stated, best.reading, PLAIN
    share, share_stated, alike = agreement(search, reading), agreement(search, plain), likeness(search, reading)
    figures = {"agreement_stated": share_stated, "agreement": share, "likeness": alike}
    about: Any = {"frames": len(stated.frames), "figures": figures, "assumptions": stated.assumptions}
    about["notes"] = stated.notes
    frames, found, stated_so = f"{len(stated.frames)} frames", f"{100 * share:.0f} %", f"{100 * share_stated:.0f} %"
    if share < AGREE or alike < ALIKE:
        but, expected = "however they are read", "a scene that stands still, seen from places nearby"
        if share >= _WELL:
            but, expected = "but not in colour", "pictures of the same things, with detail that can be compared"
        headline = f"no agreement: {frames} agree in {found} of the depths that two of them show, {but}; "
        headline += f"expected {expected}"
        return Answer("no agreement", headline, reading, **about)
    # Faults that are no convention, and explain as much, or what the best reading leaves.
    faults = standing(search, noise, best)
    known, known_stated = explained(search, reading), explained(search, plain)
    enough = known >= max(EXPLAINED, known_stated - _LESS) or 1 - known < _LEFT * (1 - known_stated)
    is_told = not (rivals or besides or faults) and (enough or not best.changes)
    causes = list(dict.fromkeys(differences(one.reading) for one in (best, *rivals)))
    names = tuple(dict.fromkeys([*itertools.chain(*causes), *besides]))
    if besides and not faults:
        untold = f"more than one of {_labels(names)} differs, or something else does"
    else:
        untold = " or ".join([*(_labels(cause) for cause in causes if cause), *faults])
        if known < EXPLAINED:
            untold += f" (explains {known:.1%} of the depths that nothing hides, {known_stated:.1%} as stated)"
    is_right = not (best.changes or besides or faults)
    headline = f"right: {frames} agree as they are stated, in {found} of the depths that two of them show"
    if not is_right:
        cause = f": {_labels(differences(reading))}" if is_told else f", and the cause cannot be told: {untold}"
        headline = f"wrong{cause}. Of the depths that two frames show, {stated_so} agree as stated, {found} as found "
        headline += f"({frames})"
    ways = [] if is_told else [one.reading for one in (best, *rivals)]
    as_good = (
        listed([f"{CONVENTIONS[name].label}: {value(one, stated, name)}" for name in differences(one)]) for one in ways
    )
    return Answer(
        "right" if is_right else "wrong",
        headline,
        reading,
        [_finding(search, reading, name, "" if is_told or name not in names else untold) for name in CONVENTIONS],
        is_told,
        list(as_good),
        [*conventions.code(reading, stated)] if is_told else [],
        **about,
    )


def _labels(names: Sequence[str]) -> str:
    return listed([CONVENTIONS[name].label for name in names])


def _finding(search: Search, best: Reading, name: str, untold: str) -> Finding:
    """Return what is found of a convention. untold: why the best reading does not tell it."""
    stated, convention, differ = search.stated, CONVENTIONS[name], differences(best)
    takes = f"it takes {convention.needs}"
    if untold:
        return Finding(name, convention.label, value(PLAIN, stated, name), True, False, why=f"{untold}; {takes}")
    # The nearest readings in which the convention is another one.
    if name == "ray":
        others = [attrs.evolve(best, along=0.0 if best.along else 1.0)]
    elif name == "encoding" or convention.numbers:
        others = [restored(best, name)] if name in differ else []
    else:
        others = [
            near
            for near in search.discrete(best)
            if {*differences(near)} ^ {*differ} <= {name}
            and near.along == best.along
            and value(near, stated, name) != value(best, stated, name)
        ]
    score, *scores = (search.coarse.by_block(search.coarse.score(one)) for one in (best, *others))
    margin = min((standard_errors(score - other) for other in scores), default=None)
    is_ahead, told = margin is None or margin >= SURE, True
    if name in differ:
        margin = margin if is_ahead else None
    elif convention.numbers and name != "ray":
        numbers, steps = convention.numbers, search.steps(best)
        # Unless it is part of what is found, numbers that are known too roughly do not tell.
        is_part = {"pixel", "centre"} <= {name, *differ} or ("encoding" in differ and name in ("scale", "planes"))
        if not is_part:
            unit = {"offset": 1e3 * steps["offset"], "late_s": stated.interval_s or 1.0}
            errors = search.fitted(best, numbers)[1] if {*numbers} <= {*steps} else {"": math.inf}
            told = all(error / unit.get(number, 1.0) <= convention.vague for number, error in errors.items())
    else:
        told = is_ahead and (name != "eyes" or stated.other_eye is not None)
    why = "" if told else f"other values explain them as well; {takes}"
    return Finding(name, convention.label, value(best, stated, name), name not in differ, told, margin, why)
