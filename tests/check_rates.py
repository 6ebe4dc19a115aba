"""Misread frames of a rendered depth camera, and print how often `hmdwarp check` names the fault.

python tests/check_rates.py [CASES]    1000 by default
"""

from __future__ import annotations

import sys
from collections import Counter

import numpy as np
from wrong_frames import MISREADINGS, Recording, recordings, wrong_frames

from hmdwarp.check import Stated, check
from hmdwarp.gpu import Gpu

SCENES = ("room", "spheres")


def recorded_for(gpu: Gpu, cases: int) -> list[Recording]:
    """Return a few recordings: drawing takes time, and each is misread in many ways."""
    return recordings(gpu, SCENES, max(2, cases // 250), np.random.default_rng(1))


def missed_of(recorded: list[Recording], cases: int) -> tuple[Counter[str], Counter[str]]:
    """Return how often each misreading was tried, and how often it alone was not what was named.

    Cameras, motions, noise, gaps, worlds and numbers are random.
    """
    tried, missed = Counter[str](), Counter[str]()
    for case in range(cases):
        rng = np.random.default_rng([2, case])
        name = list(MISREADINGS)[case % len(MISREADINGS)]
        wanted = MISREADINGS[name][1]
        frames = wrong_frames(recorded[rng.integers(len(recorded))], name, rng)
        found = [one.name for one in check(Stated(frames)).findings if not one.as_stated]
        tried[name] += 1
        missed[name] += found != ([wanted] if wanted else [])
    return tried, missed


def main() -> None:
    """Print a table for the docs."""
    cases = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    with Gpu() as gpu:
        recorded = recorded_for(gpu, cases)
    tried, missed = missed_of(recorded, cases)
    total = missed.total()
    print(f"{cases - total} of {cases} random cases were named right, {1 - total / cases:.1%}.\n")
    print("| misread as | cases | named right |\n| --- | ---: | ---: |")
    for name, count in tried.items():
        print(f"| {name} | {count} | {1 - missed[name] / count:.0%} |")


if __name__ == "__main__":
    main()
