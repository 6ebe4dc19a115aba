"""Sweeps on two local workers beside the same in one process, and what they cost: docs/scale.md.

    python tests/sweep_scale.py [CASES]

One part of the bench loses a worker in the middle, and is interrupted and resumed; merged with the
other part it must equal the plain run. Times are processor time, so that other work on the machine
counts for little.
"""

from __future__ import annotations

import json
import os
import resource
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import attrs
import psutil

ROOT = Path(__file__).resolve().parents[1]
CHEAP = (
    *("--scene", "planes", "--size", "48x40", "--seconds", "0.3", "--start", "1", "--instants", "1", "--rounds", "1"),
    *("--guard", "1.1", "--warp", "rotation", "--fill", "none", "--quiet", "--rate", "60"),
)
# A core for each worker: the software renderer would take all of them.
ALONE = {"LP_NUM_THREADS": "0", "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
COMMAND = (sys.executable, "-m", "hmdwarp", "bench")
NOT_COMPARED = ("time_ms", "machine")


def started(*words: object) -> subprocess.Popen:
    return subprocess.Popen([*COMMAND, *map(str, words)], cwd=ROOT, env={**os.environ, **ALONE})


def finished(*words: object) -> tuple[float, float]:
    """Run a bench to its end; return wall and processor seconds of it and its children."""
    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    status = started(*words).wait()
    assert status == 0, (status, words)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.monotonic() - began, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def kept(out: Path) -> int:
    return len(list((out / "cases").glob("*.json")))


def rows(out: Path) -> list[dict]:
    data = json.loads((out / "bench.json").read_text(encoding="utf-8"))
    return [{key: value for key, value in row.items() if key not in NOT_COMPARED} for row in data["rows"]]


def broken(*words: object, out: Path, kill_at: int, stop_at: int) -> tuple[int, int]:
    """Run a bench on two workers; kill one, then interrupt it. Return the cases kept each time."""
    driver, moments = started(*words, "--cluster", "local:2", "--out", out), []
    while driver.poll() is None:
        if len(moments) == 0 and kept(out) >= kill_at:
            workers = [
                child for child in psutil.Process(driver.pid).children() if "spawn_main" in " ".join(child.cmdline())
            ]
            moments.append(kept(out))
            workers[0].kill()
        if len(moments) == 1 and kept(out) >= stop_at:
            moments.append(kept(out))
            driver.send_signal(signal.SIGINT)
            break
        time.sleep(0.005)
    assert driver.wait() == 130 and len(moments) == 2, (driver.returncode, moments)
    return moments[0], moments[1]


def whole(folder: Path, count: int) -> dict:
    """Return what became of a sweep that lost a worker, was resumed and merged."""
    latencies = ",".join(str(20 + 4 * k) for k in range(count // 2))
    both = (*CHEAP, "--latency", latencies)
    wall_s, plain_s = finished("walk", "look-around", *both, "--workers", "0", "--out", folder / "plain")
    first = folder / "walk"
    killed, stopped = broken("walk", *both, out=first, kill_at=count // 8, stop_at=count // 4)
    before = {path.name: path.read_bytes() for path in (first / "cases").glob("*.json")}
    finished("walk", *both, "--cluster", "local:2", "--resume", "--out", first)
    after = {path.name: path.read_bytes() for path in (first / "cases").glob("*.json")}
    assert before.items() <= after.items() and len(after) == count // 2
    finished("look-around", *both, "--cluster", "local:2", "--out", folder / "look-around")
    finished("merge", first, folder / "look-around", "--quiet", "--out", folder / "merged")
    assert rows(folder / "merged") == rows(folder / "plain")
    sizes = [path.stat().st_size for path in (folder / "plain" / "cases").glob("*.json")]
    return {
        "cases": count,
        "killed": killed,
        "stopped": stopped,
        "case_bytes": statistics.mean(sizes),
        "plain_s": plain_s,
        "wall_s": wall_s,
    }


@attrs.frozen
class Efficiency:
    """What two workers cost beside one, in processor time."""

    # Of a further case on one worker, over the same on two.
    per_case: float
    # Of the whole run of `cases` cases, the start of the workers included.
    whole: float
    cases: int
    # Of one more worker: its start and its look at the machine.
    worker_s: float


def efficiency(folder: Path, few: int = 6, many: int = 24, turns: int = 2) -> Efficiency:
    """Return what cases take on one worker and on two; a run of few cases tells the start."""
    dear = (*CHEAP, "--size", "240x300", "--instants", "2", "--fill", "pyramid")
    took: dict[tuple[int, int], list[float]] = {(workers, n): [] for n in (few, many) for workers in (1, 2)}
    for turn in range(turns):
        for (workers, count), seconds in took.items():
            latencies = ",".join(str(40 + 20 * k) for k in range(count))
            out = folder / f"{workers}-{count}-{turn}"
            words = ("walk", *dear, "--latency", latencies, "--cluster", f"local:{workers}", "--out", out)
            seconds.append(finished(*words)[1])
    least = {key: min(seconds) for key, seconds in took.items()}
    one, two = (least[workers, many] - least[workers, few] for workers in (1, 2))
    started = [least[workers, few] - part / (many - few) * few for workers, part in ((1, one), (2, two))]
    return Efficiency(one / two, least[1, many] / least[2, many], many, started[1] - started[0])


def efficiency_text(found: Efficiency) -> str:
    return (
        f"- A case of 240x300 on one worker took {found.per_case:.2f} of the processor time that it took on two, and "
        f"{found.cases} cases with\n  the start of the workers {found.whole:.2f}: one more worker costs "
        f"{found.worker_s:.1f} s once, for its start and its look at the machine.\n"
    )


def light(folder: Path, count: int, content: Path) -> tuple[float, float]:
    """Return processor seconds and MB of driver and scheduler for cases that cost nothing."""
    words = (
        "-m",
        "tests.experiments.sweep.cheap",
        folder / str(count),
        count,
        "--cluster",
        "local:1",
        "--file",
        content,
    )
    done = subprocess.run(
        [sys.executable, *map(str, words)], cwd=ROOT, capture_output=True, text=True, check=True, env=os.environ
    )
    seconds, kilobytes = done.stdout.split()
    return float(seconds), float(kilobytes) / 1e3


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        found = whole(folder, count)
        together = efficiency(folder)
        content = folder / "row.json"
        content.write_bytes(b"x" * round(found["case_bytes"]))
        few, many = 500, 1500  # the logs of Dask, which have an end, are full by then
        (few_s, few_mb), (many_s, many_mb) = (light(folder, number, content) for number in (few, many))
    each_ms, each_kb = (many_s - few_s) / (many - few) * 1e3, (many_mb - few_mb) / (many - few) * 1e3
    case_s, rows_mb = found["plain_s"] / count, found["case_bytes"] * 1e-6
    trace_mb = (ROOT / "recordings" / "walk.csv").stat().st_size * 1e-6
    print(
        f"- {count} cases in one process, and as two parts on two local workers. One part lost a worker when\n"
        f"  {found['killed']} of its {count // 2} cases were done, was interrupted at {found['stopped']} and resumed."
        " Merged, all rows equal\n  those of the plain run but for times.\n" + efficiency_text(together)
    )
    ten = 10_000
    lines = [
        ("work: a tiny case here takes", f"{case_s:.2f} s of processor time", f"{ten * case_s / 100:.0f} s each"),
        ("driver and scheduler, per case", f"{each_ms:.1f} ms", f"{ten * each_ms * 1e-3:.0f} s"),
        ("memory of both, per case", f"{each_kb:.0f} kB", f"{few_mb + ten * each_kb * 1e-3:.0f} MB with the start"),
        ("a case's result", f"{rows_mb * 1e3:.1f} kB a row", f"{ten * rows_mb:.0f} MB for a row in each"),
        ("a trace, once to each machine", f"{trace_mb:.1f} MB", f"{100 * trace_mb:.0f} MB"),
        ("a worker that dies", "the case under way", f"{case_s:.1f} s again"),
        ("the scheduler or driver dies", "the cases under way", f"{100 * case_s:.0f} s of processor time again"),
    ]
    print("| what | measured | 10,000 such cases on 100 machines |\n| --- | --- | --- |")
    for line in lines:
        print(f"| {' | '.join(line)} |")


if __name__ == "__main__":
    main()
