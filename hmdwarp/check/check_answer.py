"""What frames say about each convention, and the code that reads them right."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..errors import listed
from ..gpu.textures import flip_rows
from ..poses.assumptions import assumption_rows
from ..report import labelled_strip, magma
from . import conventions
from .conventions import CENTRE, CONVENTIONS, ENCODING, EYES, PIXEL, PLANES, RAY, ROWS, SCALE, TIME, differences, value
from .decide import AGREE, ALIKE, EXPLAINED, FAULTS, WELL, Decision, agreement, decide, likeness
from .search import SURE, Overlap, Search, standard_errors
from .stated_frames import Array, Reading, Stated

_STILL_PX = 0.5  # median shift between two readings: below it they show the same


@attrs.frozen
class Finding:
    """What the frames say about one convention."""

    name: str
    label: str
    value: str  # what was found, or what is stated where it cannot be told
    as_stated: bool
    told: bool
    margin: float | None = None  # standard errors by which the nearest other reading is worse; None for numbers
    why: str = ""  # why it cannot be told; "" where it can


@attrs.frozen(eq=False)
class Answer:
    """What the frames say, and what they would say if read that way."""

    decision: Decision
    findings: tuple[Finding, ...]
    agreement_stated: float  # share of the depths in view of two frames that agree within 5 %
    agreement: float
    likeness: float  # correlation of their brightness where depths agree
    as_good: tuple[str, ...]  # what it may be, where frames do not tell: each explains them as well
    code: tuple[str, ...]  # empty where the cause is not known

    def __repr__(self) -> str:
        return f"<Answer {self.headline}>"

    @property
    def reading(self) -> Reading:
        """The reading under which the frames agree best."""
        return self.decision.best.reading

    @property
    def agree(self) -> bool:
        """Whether the frames agree under it."""
        return self.agreement >= AGREE and self.likeness >= ALIKE

    @property
    def verdict(self) -> str:
        """Return "right", "wrong" (of what, the decision may tell), or "no agreement"."""
        if not self.agree:
            return "no agreement"
        return "wrong" if differences(self.reading) or self.decision.besides or self.decision.faults else "right"

    @property
    def headline(self) -> str:
        """The verdict in one sentence."""
        frames, share = f"{len(self.decision.search.stated.frames)} frames", f"{100 * self.agreement:.0f} %"
        if self.verdict == "right":
            return f"right: {frames} agree as they are stated, in {share} of the depths that two of them show"
        if self.verdict == "wrong":
            cause = f": {_labels(differences(self.reading))}"
            if not self.decision.is_told:
                cause = f", and the cause cannot be told: {untold(self.decision)}"
            return (
                f"wrong{cause}. Of the depths that two frames show, {100 * self.agreement_stated:.0f} % agree "
                f"as stated, {share} as found ({frames})"
            )
        but, expected = "however they are read", "a scene that stands still, seen from places nearby"
        if self.agreement >= WELL:
            but, expected = "but not in colour", "pictures of the same things, with detail that can be compared"
        return (
            f"no agreement: {frames} agree in {share} of the depths that two of them show, {but}; expected {expected}"
        )

    def as_json(self) -> dict[str, Any]:
        """Return what `--json` prints."""
        return {
            "verdict": self.verdict,
            "told": self.agree and self.decision.is_told,
            "frames": len(self.decision.search.stated.frames),
            "agreement_stated": self.agreement_stated,
            "agreement": self.agreement,
            "likeness": self.likeness,
            "conventions": [attrs.asdict(finding) for finding in self.findings] if self.agree else [],
            "as_good": list(self.as_good),
            "code": list(self.code) if self.agree else [],
            "assumptions": assumption_rows(self.decision.search.stated.assumptions),
            "notes": list(self.decision.search.stated.notes),
        }


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
    decision = decide(search := Search(stated))
    best = decision.best.reading
    ways = [] if decision.is_told else [one.reading for one in (decision.best, *decision.rivals)]
    return Answer(
        decision,
        tuple(_finding(decision, name) for name in CONVENTIONS),
        agreement(search, Reading()),
        agreement(search, best),
        likeness(search, best),
        tuple(
            listed([f"{CONVENTIONS[name].label}: {value(one, stated, name)}" for name in differences(one)])
            for one in ways
        ),
        tuple(conventions.code(best, stated)) if decision.is_told else (),
    )


def untold(decision: Decision) -> str:
    """Return what it may be, where frames do not tell, and what it is not."""
    if decision.besides and not decision.faults:
        named = dict.fromkeys([*(name for names in decision.causes for name in names), *decision.besides])
        return f"more than one of {_labels(tuple(named))} differs, or something else does"
    causes = [*(_labels(names) for names in decision.causes if names), *decision.faults]
    share, excluded = decision.explained, [one for one in FAULTS if one not in decision.faults]
    few = "" if share[0] >= EXPLAINED else " (explains {:.1%} of the depths that nothing hides, {:.1%} as stated)"
    return f"{' or '.join(causes)}{few.format(*share)}{f'; excluded: {listed(excluded)}' if excluded else ''}"


def _labels(names: Sequence[str]) -> str:
    return listed([CONVENTIONS[name].label for name in names])


def _finding(decision: Decision, name: str) -> Finding:
    """Return what the decision says of a convention, or whether frames show it as stated."""
    search, best, convention = decision.search, decision.best.reading, CONVENTIONS[name]
    stated, differ = search.stated, differences(best)
    found = Finding(name, convention.label, value(best, stated, name), name not in differ, True)

    def unknown(why: str, **other: Any) -> Finding:
        why = f"{why.partition('; excluded')[0]}; it takes {convention.needs}"
        return attrs.evolve(found, told=False, why=why, **other)

    if not decision.is_told and name in {*itertools.chain(*decision.causes), *decision.besides}:
        return unknown(untold(decision), value=value(Reading(), stated, name), as_stated=True)
    others = list(_others(search, best, name))
    score, *scores = (search.coarse.by_block(np.nan_to_num(search.coarse.score(one)))[0] for one in (best, *others))
    margins = [standard_errors(score - other) for other in scores]
    if name in differ:
        sure = min(margins, default=0.0)
        return attrs.evolve(found, margin=sure if sure >= SURE else None)
    why, margin = "", min(margins, default=None)
    if convention.numbers and name != RAY:
        known = {name, *differ}
        is_part = {PIXEL, CENTRE} <= known or (ENCODING in known and name in (SCALE, PLANES))  # of what is found
        why = "" if is_part else _vague(search, best, name)
    elif name == EYES and stated.other_eye is None:
        why = "these are not of both eyes"
    elif margin is not None and margin < SURE:
        nearest = others[margins.index(margin)]
        a, b = (search.fine.residuals(which) for which in (best, nearest))
        apart = np.linalg.norm(a.pixel - b.pixel, axis=-1)[a.seen & b.seen]
        shift = float(np.median(apart)) if len(apart) else math.inf
        why = "fits as well, with other numbers" if margin > -SURE else "fits better, and another change better still"
        why = f"would move pixels by only {shift:.2g}" if shift < _STILL_PX and name != ROWS else why
        why = f"{value(nearest, stated, name)} {why}"
    return unknown(why, margin=margin) if why else attrs.evolve(found, margin=margin)


def _others(search: Search, best: Reading, name: str) -> Iterator[Reading]:
    """Yield the readings in which one convention is another one."""
    if name == RAY:
        yield attrs.evolve(best, along=0.0 if best.along else 1.0)
    elif name == ENCODING or CONVENTIONS[name].numbers:
        if name in differences(best):
            yield conventions.restored(best, name)
    else:
        for near in search.discrete(best):
            if set(differences(near)) ^ set(differences(best)) <= {name} and near.along == best.along:
                before, after = (value(which, search.stated, name) for which in (best, near))
                if before != after:
                    yield near


def _vague(search: Search, best: Reading, name: str) -> str:
    """Return why a number cannot be told, "" where it can."""
    numbers = CONVENTIONS[name].numbers
    steps = search.steps(best)
    if not set(numbers) <= set(steps):
        return "there are too few frames, or they are too far apart to know the motion between them"
    fitted = search.fitted(best, numbers)
    unit = {"offset": 1e3 * steps["offset"], "late_s": search.stated.interval_s or 1.0}
    errors = {key: float(error) / unit.get(key, 1.0) for key, error in zip(fitted.names, fitted.error, strict=True)}
    most = max(errors.values())
    if most <= CONVENTIONS[name].vague:
        return ""
    moved = search.moved_m(best)
    if name in (SCALE, PLANES, RAY) and moved * search.span(best) < 0.01:
        return f"the eye moves by only {100 * moved * search.span(best):.2g} % of the distance"
    pixels = f"known to {most:.2g} pixels only"
    words = {PIXEL: pixels, CENTRE: pixels, TIME: f"known to {most:.2g} frames only"}
    share = f"known to {100 * most:.0f} % only" if math.isfinite(most) else "nothing in them depends on it"
    return words.get(name, share)


Picture = NDArray[np.uint8]
_WORST = 0.2  # difference of the depths, in their size, that is drawn brightest
_LEAST_SEEN = 0.4  # of a picture that has to be in view from the other place


def mismatch(answer: Answer) -> Picture:
    """Return a picture of what agrees and what does not.

    Parameters
    ----------
    answer : Answer
        Of `check`.

    Returns
    -------
    (h, w, 3) uint8 array
        A strip: two frames, one as seen from the other's place, and what differs, as stated and as
        found.
    """
    search, best = answer.decision.search, answer.reading
    # Two frames that see much of the same from places far apart.
    found, at = search.coarse.residuals(best), np.stack([search.coarse.column, search.coarse.row], axis=-1)
    seen, shift = found.seen.mean(axis=1), np.linalg.norm(found.pixel - at, axis=-1)
    moved = np.array([np.median(one[good]) if good.any() else 0 for one, good in zip(shift, found.seen, strict=True)])
    one, other = map(int, search.coarse.pairs[np.argmax(np.where(seen > _LEAST_SEEN, moved, seen * 1e-3))])
    panels = []
    readings = {"as stated": Reading()} if best == Reading() else {"as stated": Reading(), "as found": best}
    for words, reading in readings.items():
        there, depth = _moved(search.stated, reading, one, other)
        target, shown = (_upright(search.stated.frames[which].colour, reading) for which in (one, other))
        error = np.abs(there.astype(int) - target).mean(axis=2) * there.any(axis=2) / 128
        panels += [
            ("one frame", target),
            ("another", shown),
            (f"that, moved here: {words}", there),
            ("colour differs", magma(error)),
            ("depth differs", magma(depth)),
        ]
    return labelled_strip(panels, columns=5)


def _moved(stated: Stated, reading: Reading, one: int, other: int) -> tuple[Picture, Array]:
    """Return the other frame as seen from the place of one, and how much depth differs."""
    overlap = Overlap(stated, stated.fine, np.array([[one, other]]), None, between=False)
    found = overlap.residuals(reading)
    size = stated.fine.numbers.shape[1:]
    column, row = np.rint(found.pixel[0]).astype(int).T
    moved = _upright(stated.frames[other].colour, reading)[row, column].reshape(*size, 3)
    known = found.seen[0].reshape(size) & ~np.isnan(stated.fine.numbers[one])
    depth = np.nan_to_num(np.abs(found.depth[0]).reshape(size) / _WORST) * known
    moved = np.where(known[..., None], moved, 0).astype(np.uint8)
    return (flip_rows(moved), flip_rows(depth)) if reading.depth_rows_up else (moved, depth)


def _upright(picture: Picture, reading: Reading) -> Picture:
    return flip_rows(picture) if reading.colour_rows_up else picture
