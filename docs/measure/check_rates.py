"""Misread frames of a rendered depth camera; print how often `hmdwarp check` names the fault."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator

import attrs
import numpy as np
from apparatus import options, print_table
from wrong_frames import MISREADINGS, Frames, Recording, recordings, right_and_wrong, two_misreadings

from hmdwarp.check import Answer, Reading, Stated, check
from hmdwarp.check.search import Overlap
from hmdwarp.gpu import Gpu

SCENES = ("room", "spheres")
SAME_PX = 0.3  # two wrong conventions may be the same as another one: its code puts pixels where they are
OUTCOMES = ("right", "cannot tell", "wrong")


def recorded_for(gpu: Gpu, cases: int) -> list[Recording]:
    """Return a few recordings: drawing takes time, and each is misread in many ways."""
    return recordings(gpu, SCENES, max(2, cases // 250), np.random.default_rng(1))


@attrs.frozen(eq=False)
class Result:
    """What a case was, and what was found."""

    # Joined by " + ".
    misread: str
    right: Frames
    wrong: Frames
    answer: Answer
    # How far off the named reading finds pixels; infinite where none is named.
    off_px: float

    @property
    def told(self) -> bool:
        """Whether it says what is wrong."""
        return self.answer.is_told

    @property
    def named(self) -> list[str]:
        return [finding.name for finding in self.answer.findings if self.told and not finding.as_stated]

    @property
    def wanted(self) -> list[str]:
        return sorted(one for name in self.misread.split(" + ") if (one := MISREADINGS[name][1]))

    @property
    def is_right(self) -> bool:
        return self.told and sorted(self.named) == self.wanted

    @property
    def outcome(self) -> str:
        """Return the column of the table."""
        if self.is_right or (self.told and len(self.wanted) > 1 and self.off_px < SAME_PX):
            return "right"
        left = {*self.wanted} - {*self.named}
        is_part = (
            left < {*self.wanted}
            and {*self.named} < {*self.wanted}
            and left <= {one.name for one in self.answer.findings if not one.told}
        )
        return "cannot tell" if not self.told or is_part else "wrong"


def results(recorded: list[Recording], cases: Iterable[int], faults: int = 1) -> Iterator[Result]:
    """Yield the result of each case: random cameras, motions, noise, gaps, worlds and numbers."""
    for case in cases:
        rng = np.random.default_rng([2, case] if faults == 1 else [3, case])
        names = two_misreadings(rng) if faults == 2 else (list(MISREADINGS)[case % len(MISREADINGS)],)
        right, wrong = right_and_wrong(recorded[rng.integers(len(recorded))], names, rng)
        answer = check(Stated(wrong))
        off = off_px(right, wrong, answer.reading, "rows up" in names) if answer.is_told else math.inf
        yield Result(" + ".join(names), right, wrong, answer, off)


def off_px(right: Frames, wrong: Frames, reading: Reading, turned_over: bool = False) -> float:
    """Return how far from their place a reading finds the pixels of a frame in another one."""
    pairs, height = np.array([[1, 6], [9, 4]]), right[0].depth.shape[0]
    there, found = (
        Overlap(stated, stated.fine, pairs, None, between=False).residuals(one)
        for stated, one in ((Stated(right), Reading()), (Stated(wrong), reading))
    )
    pixel, true = (np.stack([one.column, one.line], axis=-1) for one in (found, there))
    seen = found.seen
    if turned_over:
        pixel[..., 1] = pixel[..., 1] if reading.depth_rows_up else height - 1 - pixel[..., 1]
        pixel, seen = (
            values.reshape(2, height, -1, *values.shape[2:])[:, ::-1].reshape(values.shape) for values in (pixel, seen)
        )
    both = seen & there.seen
    return float(np.percentile(np.linalg.norm(pixel - true, axis=-1)[both], 90)) if both.any() else math.inf


def table(found: Iterable[Result]) -> list[list[str]]:
    """Return a row for each misreading: how often it was tried, and what came of it."""
    counts: dict[str, Counter[str]] = {name: Counter() for name in MISREADINGS}
    for trial in found:
        for name in trial.misread.split(" + "):
            counts[name][trial.outcome] += 1
    known = {name: count for name, count in counts.items() if count}
    return [[name, *map(str, (count.total(), *(count[one] for one in OUTCOMES)))] for name, count in known.items()]


def main() -> None:
    """Print a table for the docs."""
    chosen = options(__doc__, cases=(1000, "random"), two=(False, "misread two conventions in each case"))
    faults = 1 + chosen.two
    with Gpu() as gpu:
        recorded = recorded_for(gpu, chosen.cases)
    found = [attrs.evolve(one, right=[], wrong=[]) for one in results(recorded, range(chosen.cases), faults)]
    outcomes = Counter(trial.outcome for trial in found)
    shares = ", ".join(f"{outcomes[outcome]} {outcome}" for outcome in OUTCOMES)
    print(f"Of {len(found)} random cases with {faults} {'fault' if faults == 1 else 'faults'}: {shares}.")
    print("Kinds that were not always right:\n")
    rows = [(name, cases, right, *rest) for name, cases, right, *rest in table(found) if right != cases]
    print_table(("misread as", "cases", *OUTCOMES), rows)


if __name__ == "__main__":
    main()
