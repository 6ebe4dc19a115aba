"""What frames say about each convention, and the code that reads them right."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import attrs
import numpy as np

from ..errors import listed
from .conventions import (
    CENTRE,
    CONVENTIONS,
    ENCODING,
    EYES,
    PIXEL,
    PLANES,
    RAY,
    ROWS,
    SCALE,
    TIME,
    WIDTH,
    code,
    differences,
    restored,
    value,
)
from .decide import ALIKE, WELL, Decision, agreement, decide, likeness
from .frame_reading import Reading
from .overlap import LATE, OFFSET
from .search import SURE, Search, margin, standard_errors
from .stated_frames import Stated

_AGREE = 0.5  # share of the depths: below it, frames do not agree
_MOST_NAMED = 2  # conventions that are likely to be wrong at once: more numbers stand in for others
_STILL_PX = 0.5  # median shift between two readings: below it they show the same


@attrs.frozen
class Finding:
    """What the frames say about one convention."""

    name: str
    label: str
    # What was found, or what is stated where it cannot be determined.
    value: str
    as_stated: bool
    told: bool
    # Standard errors by which the nearest other reading is worse; None for numbers.
    margin: float | None = None
    # Why it cannot be determined; "" where it can.
    why: str = ""


@attrs.frozen(eq=False)
class Answer:
    """What the frames say, and what they would say if read that way."""

    decision: Decision
    findings: tuple[Finding, ...]
    # Share of the depths in view of two frames that agree within 5 %.
    agreement_stated: float
    agreement: float
    # Correlation of their brightness where depths agree.
    likeness: float
    # Other readings under which the frames agree as well.
    as_good: tuple[str, ...]
    code: tuple[str, ...]

    @property
    def reading(self) -> Reading:
        """The reading under which the frames agree best."""
        return self.decision.best.reading

    @property
    def agree(self) -> bool:
        """Whether the frames agree under it."""
        return self.agreement >= _AGREE and self.likeness >= ALIKE

    @property
    def verdict(self) -> str:
        """Return "right", "wrong" (the findings say what), "unclear", or "no agreement".

        unclear: what fits best differs from what is stated by something that cannot be told, or by
        more than is likely.
        """
        if not self.agree:
            return "no agreement"
        if not self._changed:
            return "right"
        is_sure = len(self._changed) <= _MOST_NAMED and all(finding.told for finding in self._changed)
        return "wrong" if is_sure else "unclear"

    @property
    def _changed(self) -> list[Finding]:
        return [finding for finding in self.findings if not finding.as_stated]

    def headline(self) -> str:
        """Return the verdict in one sentence."""
        frames = f"{len(self.decision.search.stated.frames)} frames"
        share = f"{100 * self.agreement:.0f} %"
        if self.verdict == "right":
            return f"right: {frames} agree as they are stated, in {share} of the depths that two of them show"
        changed = listed([finding.label for finding in self._changed])
        if self.verdict == "unclear":
            return (
                f"unclear: {frames} fit a little better with another {changed}, which cannot be told from them. Of the "
                f"depths that two frames show, {100 * self.agreement_stated:.0f} % agree as stated, {share} so"
            )
        if self.verdict == "wrong":
            several = ", or something else that fits as well" if self.as_good else ""
            stated = f"{100 * self.agreement_stated:.0f} % agree as stated"
            return (
                f"wrong: {changed}{several}. Of the depths that two frames show, {stated}, {share} as found ({frames})"
            )
        if self.agreement >= WELL:
            return (
                f"no agreement: {frames} agree in {share} of the depths that two of them show, but not in colour; "
                "expected pictures of the same things, with detail that can be compared"
            )
        return (
            f"no agreement: {frames} agree in {share} of the depths that two of them show, however they are read; "
            "expected a scene that stands still, seen from places nearby, and the field of view of the camera"
        )

    def as_json(self) -> dict[str, Any]:
        """Return what `--json` prints."""
        return {
            "verdict": self.verdict,
            "frames": len(self.decision.search.stated.frames),
            "agreement_stated": self.agreement_stated,
            "agreement": self.agreement,
            "likeness": self.likeness,
            "conventions": [attrs.asdict(finding) for finding in self.findings] if self.agree else [],
            "as_good": list(self.as_good),
            "code": list(self.code),
        }


def check(stated: Stated) -> Answer:
    """Return under which conventions the frames agree."""
    search = Search(stated)
    decision = decide(search)
    best = decision.best.reading
    findings = tuple(_finding(decision, name) for name in CONVENTIONS)
    rivals = [
        other
        for other in decision.others
        if other.changes and max(margin(other, decision.best), abs(_margin(decision, other.reading))) < SURE
    ]
    rivals = [rival for rival in rivals if differences(rival.reading) != differences(best)]
    as_good = dict.fromkeys(
        listed(
            [f"{CONVENTIONS[name].label}: {value(rival.reading, stated, name)}" for name in differences(rival.reading)]
        )
        for rival in (rivals if differences(best) else ())
    )
    answer = Answer(
        decision,
        findings,
        agreement(search, Reading()),
        agreement(search, best),
        likeness(search, best),
        tuple(as_good),
        (),
    )
    # Code to paste is for what is certain.
    is_sure = answer.verdict == "wrong" and not as_good
    return attrs.evolve(answer, code=tuple(code(best, stated))) if is_sure else answer


def _finding(decision: Decision, name: str) -> Finding:
    search, best = decision.search, decision.best.reading
    known = set(differences(best))
    changed = name in known
    finding = Finding(name, CONVENTIONS[name].label, value(best, search.stated, name), not changed, True)
    if name == EYES and search.stated.other_eye is None:
        return _unknown(finding, "these are not of both eyes")
    if {PIXEL: CENTRE, CENTRE: PIXEL, SCALE: ENCODING, PLANES: ENCODING}.get(name) in known:
        return finding  # another name of the same numbers
    if CONVENTIONS[name].numbers and not (changed and name != RAY):
        why = _vague(search, best, name)
        return _unknown(finding, why) if why else finding
    others = list(_others(search, best, name))
    if not others:
        return finding
    margins = [_margin(decision, rival) for rival in others]
    if CONVENTIONS[name].numbers and changed:
        # Small numbers show on the fine pictures.
        closely = (search.candidate(rival, decision.noise, 0) for rival in others)
        margins = [max(pair) for pair in zip(margins, (margin(near, decision.best) for near in closely), strict=True)]
    least = int(np.argmin(margins))
    if margins[least] >= SURE:
        return attrs.evolve(finding, margin=margins[least])
    shift = _shift(search, best, others[least])
    other = value(others[least], search.stated, name)
    why = (
        f"{other} would move pixels by only {shift:.2g}"
        if shift < _STILL_PX and name != ROWS
        else f"{other} fits as well, with other numbers"
        if margins[least] > -SURE
        else f"{other} fits better, and another change better still"
    )
    return _unknown(attrs.evolve(finding, margin=margins[least]), why)


def _unknown(finding: Finding, why: str) -> Finding:
    return attrs.evolve(finding, told=False, why=f"{why}; it takes {CONVENTIONS[finding.name].needs}")


def _others(search: Search, best: Reading, name: str) -> Iterator[Reading]:
    """Yield the readings in which one convention is another one."""
    if name in (ENCODING, PLANES, SCALE, TIME, PIXEL, CENTRE, WIDTH):
        if name in differences(best):
            yield restored(best, name)
        return
    if name == RAY:
        yield attrs.evolve(best, along=0.0 if best.along else 1.0)
        return
    for near in search.discrete(best):
        if set(differences(near)) ^ set(differences(best)) <= {name} and near.along == best.along:
            before, after = (value(which, search.stated, name) for which in (best, near))
            if before != after:
                yield near


def _margin(decision: Decision, other: Reading) -> float:
    """Return by how many standard errors of the coarse score another reading is worse."""
    coarse = decision.search.coarse
    better, worse = (
        coarse.by_block(np.nan_to_num(coarse.score(reading)))[0] for reading in (decision.best.reading, other)
    )
    return standard_errors(better - worse)


def _shift(search: Search, one: Reading, other: Reading) -> float:
    """Return the median shift between two readings, in pixels."""
    a, b = (search.fine.residuals(which) for which in (one, other))
    both = a.seen & b.seen
    return float(np.median(np.linalg.norm(a.pixel[both] - b.pixel[both], axis=-1))) if both.any() else math.inf


def _vague(search: Search, best: Reading, name: str) -> str:
    """Return why a number cannot be determined, "" where it can."""
    numbers = CONVENTIONS[name].numbers
    steps = search.steps(best)
    if not set(numbers) <= set(steps):
        return "there are too few frames, or they are too far apart to know the motion between them"
    fitted = search.fitted(best, numbers)
    unit = {OFFSET: 1e3 * steps[OFFSET], LATE: search.stated.interval_s or 1.0}
    errors = {key: float(error) / unit.get(key, 1.0) for key, error in zip(fitted.names, fitted.error, strict=True)}
    most = max(errors.values())
    if most <= CONVENTIONS[name].vague:
        return ""
    moved = search.moved_m(best)
    if name in (SCALE, PLANES, RAY) and moved * search.span(best) < 0.01:
        return f"the eye moves by only {100 * moved * search.span(best):.2g} % of the distance"
    words = {PIXEL: f"known to {most:.2g} pixels only", TIME: f"known to {most:.2g} frames only"}
    return words.get(
        name, f"known to {100 * most:.0f} % only" if math.isfinite(most) else "nothing in them depends on it"
    )
