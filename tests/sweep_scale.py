"""Sweeps on two local workers beside the same in one process, and what they cost: docs/scale.md.

    python tests/sweep_scale.py [CASES] [WORKERS' LATENCIES STEP]

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

import psutil

ROOT = Path(__file__).resolve().parents[1]
CHEAP = (
    *("--scene", "planes", "--size", "48x40", "--seconds", "0.3", "--start", "1", "--instants", "1", "--rounds", "1"),
    *("--guard", "1.1", "--no-grid", "--no-fused", "--warp", "rotation", "--fill", "none", "--quiet", "--rate", "60"),
)
# A core for each worker: the software renderer would take all of them.
ALONE = {"LP_NUM_THREADS": "0", "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
COMMAND = (sys.executable, "-m", "hmdwarp", "bench")
NOT_COMPARED = ("time_ms", "passes", "machine")


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
            workers = [one for one in psutil.Process(driver.pid).children() if "spawn_main" in " ".join(one.cmdline())]
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


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    with tempfile.TemporaryDirectory() as name:
        found = whole(Path(name), count)
    print(
        f"{found['cases']} cases in one process, and as two parts on two local workers. One part lost a worker when "
        f"{found['killed']} of its {count // 2} cases were done, was interrupted at {found['stopped']} and resumed. "
        "Merged, all rows equal those of the plain run but for times."
    )
    print(json.dumps(found))


if __name__ == "__main__":
    main()
