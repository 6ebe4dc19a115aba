"""What whole commands take, and what they took before issue 36: a table for docs/performance.md.

Processor time of all their processes, in turns with those of an earlier revision of this
repository, whose history must be there. That one draws one sample a pixel.
"""

from __future__ import annotations

import argparse
import io
import os
import resource
import subprocess
import sys
import tarfile
import tempfile
import time
from pathlib import Path

import attrs

ROOT = Path(__file__).parents[1]
BEFORE = "c95b5900"
REPLAY = "replay look-around --scene room --latency 200 --size 640x400 --headset rift-dk1"
TREES = {"before": (), "4 samples": (), "1 sample": ("--samples", "1")}


@attrs.frozen
class Case:
    """A command, and the share of what it took before that it is to take."""

    told: str
    command: str
    at_most: float | None
    # Of the head that it shows, for what a second of it takes.
    seconds: float | None = None


CASES = (
    Case(
        "`make replay`, half a second, every refresh measured",
        f"{REPLAY} --warp iterative --fill memory+pyramid --against none,forward+interpolate --metrics-every 1 "
        "--seconds 0.5",
        0.6,
    ),
    Case("`replay` by its defaults, two seconds", f"{REPLAY} --seconds 2", None, 2.0),
    Case(
        "`compare` of `depth_image` and `rotation`",
        "compare look-around --strategy depth_image,rotation --latency 200",
        0.5,
    ),
    Case(
        "`bench` of two warps, two latencies, three instants",
        "bench --size 640x400 --latency 100 --latency 200 --warp forward,iterative --instants 3",
        0.5,
    ),
)
PER_SECOND = 3.0  # seconds on the clock for one of the head: 30 in 90


def took(case: Case, tree: Path, more: tuple[str, ...]) -> tuple[float, float]:
    """Return seconds of processor time, and those on the clock. Raises: SystemExit."""
    before, begun = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        words = [sys.executable, "-m", "hmdwarp", *case.command.split(), *more, "--quiet", "--out", f"{folder}/out"]
        done = subprocess.run(
            words, cwd=tree, env=os.environ | {"PYTHONPATH": str(tree)}, capture_output=True, text=True, check=False
        )
    if done.returncode:
        raise SystemExit(f"{' '.join(words)}: {done.stderr}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return spent, time.perf_counter() - begun


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--revision", default=BEFORE, help="what to compare with")
    parser.add_argument("--rounds", type=int, default=1, help="times that each command runs; the least counts")
    options = parser.parse_args()
    print("| processor seconds of | before | four samples | of before | one sample | of before | aim |")
    print("| --- | ---: | ---: | ---: | ---: | ---: | ---: |")
    shown = ""
    with tempfile.TemporaryDirectory() as folder:
        earlier = Path(folder)
        packed = subprocess.run(["git", "-C", ROOT, "archive", options.revision], check=True, capture_output=True)
        with tarfile.open(fileobj=io.BytesIO(packed.stdout)) as files:
            files.extractall(earlier, filter="data")
        trees = {"before": earlier, "4 samples": ROOT, "1 sample": ROOT}
        for case in CASES:
            runs = [
                {name: took(case, trees[name], more) for name, more in TREES.items()} for _ in range(options.rounds)
            ]
            before, four, one = (min(run[name] for run in runs) for name in TREES)
            cells = (f"{now[0]:.1f} | {now[0] / before[0]:.2f}" for now in (four, one))
            aim = "" if case.at_most is None else f"{case.at_most:g}"
            print(f"| {case.told} | {before[0]:.1f} | {' | '.join(cells)} | {aim} |", flush=True)
            if case.seconds is not None:
                a, b, c = (found[1] / case.seconds for found in (before, four, one))
                shown = (
                    f"{case.told}: {b:.1f} s on the clock for one of the head, {c:.1f} with one sample, {a:.1f} before"
                )
    print(f"\n{shown} (aim {PER_SECOND:g})")


if __name__ == "__main__":
    main()
