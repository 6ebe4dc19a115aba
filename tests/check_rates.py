"""Misread frames of a rendered depth camera; print how often `hmdwarp check` names the fault."""

from __future__ import annotations

import argparse
import json
import math
import time
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path

import attrs
import numpy as np
from wrong_frames import MISREADINGS, Frames, Recording, recordings, right_and_wrong, two_misreadings

from hmdwarp.check import Reading, Stated, check
from hmdwarp.check.overlap import Overlap
from hmdwarp.gpu import Gpu

SCENES = ("room", "spheres")
SAME_PX = 0.3  # two wrong conventions may be the same as another one: its code puts pixels where they are
OUTCOMES = ("right", "cannot tell", "wrong")


def recorded_for(gpu: Gpu, cases: int) -> list[Recording]:
    """Return a few recordings: drawing takes time, and each is misread in many ways."""
    return recordings(gpu, SCENES, max(2, cases // 250), np.random.default_rng(1))


@attrs.frozen
class Result:
    """What a case was, and what was named."""

    case: int
    # Joined by " + ".
    misread: str
    named: list[str]
    # What it says of these frames that it cannot tell.
    open: list[str]
    # Whether it says what is wrong.
    told: bool
    # How far off the named reading finds pixels; infinite where none is named.
    off_px: float
    # How many cases there are: more of them are misread from more recordings.
    of: int

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
        is_part = left < {*self.wanted} and {*self.named} < {*self.wanted} and left <= {*self.open}
        return "cannot tell" if not self.told or is_part else "wrong"


def results(recorded: list[Recording], cases: int, done: Iterable[int] = (), faults: int = 1) -> Iterator[Result]:
    """Yield the result of each case that is not done.

    Cameras, motions, noise, gaps, worlds and numbers are random.
    """
    for case in sorted({*range(cases)} - {*done}):
        rng = np.random.default_rng([2, case] if faults == 1 else [3, case])
        names = two_misreadings(rng) if faults == 2 else (list(MISREADINGS)[case % len(MISREADINGS)],)
        right, wrong = right_and_wrong(recorded[rng.integers(len(recorded))], names, rng)
        answer = check(Stated(wrong))
        named = [finding.name for finding in answer.findings if not finding.as_stated]
        left = [finding.name for finding in answer.findings if not finding.told]
        told = answer.agree and answer.decision.is_told
        off = off_px(right, wrong, answer.reading, "rows up" in names) if told else math.inf
        yield Result(case, " + ".join(names), named if told else [], left, told, off, cases)


def off_px(right: Frames, wrong: Frames, reading: Reading, turned_over: bool) -> float:
    """Return how far from their place a reading finds the pixels of a frame in another one."""
    pairs, height = np.array([[1, 6], [9, 4]]), right[0].depth.shape[0]
    there, found = (
        Overlap(stated, stated.fine, pairs, None, between=False).residuals(one)
        for stated, one in ((Stated(right), Reading()), (Stated(wrong), reading))
    )
    pixel, seen = found.pixel.copy(), found.seen
    if turned_over:
        pixel[..., 1] = pixel[..., 1] if reading.depth_rows_up else height - 1 - pixel[..., 1]
        pixel, seen = (
            values.reshape(2, height, -1, *values.shape[2:])[:, ::-1].reshape(values.shape) for values in (pixel, seen)
        )
    both = seen & there.seen
    return float(np.percentile(np.linalg.norm(pixel - there.pixel, axis=-1)[both], 90)) if both.any() else math.inf


def missed_of(found: Iterable[Result]) -> tuple[Counter[str], Counter[str]]:
    """Return how often each misreading was tried, and how often it alone was not what was named."""
    tried, missed = Counter[str](), Counter[str]()
    for trial in found:
        tried[trial.misread] += 1
        missed[trial.misread] += not trial.is_right
    return tried, missed


def table(found: Iterable[Result]) -> Iterator[str]:
    """Yield a line for each misreading: how often it was tried, and what came of it."""
    counts: dict[str, Counter[str]] = {name: Counter() for name in MISREADINGS}
    for trial in found:
        for name in trial.misread.split(" + "):
            counts[name][trial.outcome] += 1
    yield "| misread as | cases | right | cannot tell | wrong |"
    yield "| --- | ---: | ---: | ---: | ---: |"
    for name, count in counts.items():
        if count:
            yield f"| {name} | {count.total()} | " + " | ".join(str(count[outcome]) for outcome in OUTCOMES) + " |"


def resumed(out: Path, cases: int) -> list[Result]:
    """Return the results in a file, and cut off a line that was not finished."""
    whole = out.read_bytes()
    whole = whole[: whole.rfind(b"\n") + 1]
    with out.open("r+b") as file:
        file.truncate(len(whole))
    found = [Result(**json.loads(line)) for line in whole.splitlines()]
    if other := {trial.of for trial in found} - {cases}:
        raise SystemExit(f"{out} has results of {other.pop()} cases, {cases} are wanted: take another file")
    return found


def main() -> None:
    """Print a table for the docs."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("cases", type=int, nargs="?", default=1000)
    options.add_argument("--out", type=Path, metavar="FILE", help="gets a line of JSON for each case as it is done")
    options.add_argument("--resume", action="store_true", help="leave out the cases that are in FILE already")
    options.add_argument("--two", action="store_true", help="misread two conventions in each case")
    options.add_argument("--minutes", type=float, default=math.inf, help="stop after so long, to go on with --resume")
    given = options.parse_args()
    cases, out, faults = given.cases, given.out, 1 + given.two
    if given.resume and out is None:
        options.error("--resume needs --out FILE")
    found: list[Result] = []
    if out is not None and out.exists():
        if not given.resume:
            options.error(f"{out} is there already: add --resume, or take another file")
        found = resumed(out, cases)
    with Gpu() as gpu:
        recorded = recorded_for(gpu, cases)
    until = time.monotonic() + given.minutes * 60
    for result in results(recorded, cases, [trial.case for trial in found], faults):
        found.append(result)
        if out is not None:
            with out.open("a", encoding="utf-8") as file:
                file.write(json.dumps(attrs.asdict(result)) + "\n")
        if time.monotonic() > until:
            break
    outcomes = Counter(trial.outcome for trial in found)
    shares = ", ".join(f"{outcomes[outcome]} {outcome}" for outcome in OUTCOMES)
    print(f"Of {len(found)} random cases with {faults} {'fault' if faults == 1 else 'faults'}: {shares}.\n")
    print("\n".join(table(found)))


if __name__ == "__main__":
    main()
