"""What sweeps on local workers cost: figures for docs/scale.md.

Times are processor time, so that other work on the machine counts for little.
"""

from __future__ import annotations

import os
import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from apparatus import ROOT, options, print_table

CHEAP = (
    *("--scene", "planes", "--size", "48x40", "--seconds", "0.3", "--start", "1", "--instants", "1", "--rounds", "1"),
    *("--guard", "1.1", "--warp", "rotation", "--fill", "none", "--quiet", "--rate", "60"),
)
# A core for each worker: the software renderer would take all of them.
ALONE = {"LP_NUM_THREADS": "0", "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
CASES = 10_000  # what the right column is for, on 100 machines


def finished(*words: object) -> float:
    """Run a bench to its end; return the processor seconds of it and its children."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = (sys.executable, "-m", "hmdwarp", "bench", *map(str, words))
    subprocess.run(command, cwd=ROOT, env={**os.environ, **ALONE}, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def latencies(count: int, step_ms: int) -> tuple[str, str]:
    """Return the option that makes that many cases."""
    return "--latency", ",".join(str(20 + step_ms * k) for k in range(count))


def efficiency(folder: Path, few: int, many: int, turns: int = 2) -> str:
    """Return a line on two workers beside one; a run of few cases says what the start takes."""
    dear = (*CHEAP, "--size", "240x300", "--instants", "2", "--fill", "pyramid")
    took: dict[tuple[int, int], list[float]] = {(workers, n): [] for n in (few, many) for workers in (1, 2)}
    for turn in range(turns):
        for (workers, count), seconds in took.items():
            out = folder / f"{workers}-{count}-{turn}"
            where = ("--cluster", f"local:{workers}", "--out", out)
            seconds.append(finished("walk", *dear, *latencies(count, 20), *where))
    least = {key: min(seconds) for key, seconds in took.items()}
    one, two = (least[workers, many] - least[workers, few] for workers in (1, 2))
    started = [least[workers, few] - part / (many - few) * few for workers, part in ((1, one), (2, two))]
    return (
        f"- A case of 240x300 on one worker took {one / two:.2f} of the processor time that it took on two, and "
        f"{many} cases with\n  the start of the workers {least[1, many] / least[2, many]:.2f}: one more worker costs "
        f"{started[1] - started[0]:.1f} s once, for its start and its look at the machine.\n"
    )


def light(folder: Path, count: int, content: Path) -> tuple[float, float]:
    """Return processor seconds and MB of driver and scheduler for cases that cost nothing."""
    words = ("-m", "tests.experiments.sweep.cheap", folder / str(count), count, "--cluster", "local:1")
    command = [sys.executable, *map(str, words), "--file", str(content)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    seconds, kilobytes = done.stdout.split()
    return float(seconds), float(kilobytes) / 1e3


def main() -> None:
    """Measure and print."""
    chosen = options(
        __doc__,
        cases=(200, "tiny ones in one process"),
        few=(6, "larger ones on one worker and on two"),
        many=(24, "and those that are compared"),
        empty=(1500, "cases that cost nothing, beside a third of them"),
    )
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        plain_s = finished("walk", *CHEAP, *latencies(chosen.cases, 4), "--workers", "0", "--out", folder / "plain")
        case_bytes = statistics.mean(path.stat().st_size for path in (folder / "plain" / "cases").glob("*.json"))
        together = efficiency(folder, chosen.few, chosen.many)
        content = folder / "row.json"
        content.write_bytes(b"x" * round(case_bytes))
        few, many = chosen.empty // 3, chosen.empty  # the logs of Dask, which have an end, are full by then
        (few_s, few_mb), (many_s, many_mb) = (light(folder, number, content) for number in (few, many))
    each_ms, each_kb = (many_s - few_s) / (many - few) * 1e3, (many_mb - few_mb) / (many - few) * 1e3
    case_s, rows_mb = plain_s / chosen.cases, case_bytes * 1e-6
    trace_mb = (ROOT / "recordings" / "walk.csv").stat().st_size * 1e-6
    rows = [
        ("work: a tiny case here takes", f"{case_s:.2f} s of processor time", f"{CASES * case_s / 100:.0f} s each"),
        ("driver and scheduler, per case", f"{each_ms:.1f} ms", f"{CASES * each_ms * 1e-3:.0f} s"),
        ("memory of both, per case", f"{each_kb:.0f} kB", f"{few_mb + CASES * each_kb * 1e-3:.0f} MB with the start"),
        ("a case's result", f"{rows_mb * 1e3:.1f} kB a row", f"{CASES * rows_mb:.0f} MB for a row in each"),
        ("a trace, once to each machine", f"{trace_mb:.1f} MB", f"{100 * trace_mb:.0f} MB"),
        ("a worker that dies", "the case under way", f"{case_s:.1f} s again"),
        ("the scheduler or driver dies", "the cases under way", f"{100 * case_s:.0f} s of processor time again"),
    ]
    print(together)
    print_table(("what", "measured", "10,000 such cases on 100 machines"), rows, texts=3)


if __name__ == "__main__":
    main()
