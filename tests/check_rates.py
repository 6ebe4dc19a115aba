"""Misread frames of a rendered depth camera; print how often `hmdwarp check` names the fault."""

from __future__ import annotations

import argparse
import json
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path

import attrs
import numpy as np
from wrong_frames import MISREADINGS, Recording, recordings, wrong_frames

from hmdwarp.check import Stated, check
from hmdwarp.gpu import Gpu

SCENES = ("room", "spheres")


def recorded_for(gpu: Gpu, cases: int) -> list[Recording]:
    """Return a few recordings: drawing takes time, and each is misread in many ways."""
    return recordings(gpu, SCENES, max(2, cases // 250), np.random.default_rng(1))


@attrs.frozen
class Result:
    """What a case was, and what was named."""

    case: int
    misread: str
    named: list[str]
    # How many cases there are: more of them are misread from more recordings.
    of: int

    @property
    def is_right(self) -> bool:
        wanted = MISREADINGS[self.misread][1]
        return self.named == ([wanted] if wanted else [])


def results(recorded: list[Recording], cases: int, done: Iterable[int] = ()) -> Iterator[Result]:
    """Yield the result of each case that is not done.

    Cameras, motions, noise, gaps, worlds and numbers are random.
    """
    for case in sorted({*range(cases)} - {*done}):
        rng = np.random.default_rng([2, case])
        name = list(MISREADINGS)[case % len(MISREADINGS)]
        frames = wrong_frames(recorded[rng.integers(len(recorded))], name, rng)
        yield Result(
            case, name, [finding.name for finding in check(Stated(frames)).findings if not finding.as_stated], cases
        )


def missed_of(found: Iterable[Result]) -> tuple[Counter[str], Counter[str]]:
    """Return how often each misreading was tried, and how often it alone was not what was named."""
    tried, missed = Counter[str](), Counter[str]()
    for trial in found:
        tried[trial.misread] += 1
        missed[trial.misread] += not trial.is_right
    return tried, missed


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
    given = options.parse_args()
    cases, out = given.cases, given.out
    if given.resume and out is None:
        options.error("--resume needs --out FILE")
    found: list[Result] = []
    if out is not None and out.exists():
        if not given.resume:
            options.error(f"{out} is there already: add --resume, or take another file")
        found = resumed(out, cases)
    with Gpu() as gpu:
        recorded = recorded_for(gpu, cases)
    for result in results(recorded, cases, [trial.case for trial in found]):
        found.append(result)
        if out is not None:
            with out.open("a", encoding="utf-8") as file:
                file.write(json.dumps(attrs.asdict(result)) + "\n")
    tried, missed = missed_of(sorted(found, key=lambda one: one.case))
    total = missed.total()
    print(f"{cases - total} of {cases} random cases were named right, {1 - total / cases:.1%}.\n")
    print("| misread as | cases | named right |\n| --- | ---: | ---: |")
    for name, count in tried.items():
        print(f"| {name} | {count} | {1 - missed[name] / count:.0%} |")


if __name__ == "__main__":
    main()
