"""Sweeps whose worker, scheduler or driver is killed in mid-run, and what must be true after it.

    python -m tests.experiments.sweep.killing MOMENTS [SEED]

A kill is SIGKILL. Then the run is resumed in one process.
"""

from __future__ import annotations

import json
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from contextlib import ExitStack, suppress
from pathlib import Path

import psutil

from hmdwarp.experiments.sweep import KeptCases

from .cheap import cases, sweep

ROOT = Path(__file__).resolve().parents[3]
VICTIMS = ("worker", "scheduler", "driver")
COUNT = 40
PATIENCE_S = 300


def kill_in(victim: str, out: Path, chance: random.Random) -> list[str]:
    """Kill the victim once, resume, and return what is wrong, in words."""
    out.mkdir()
    with ExitStack() as stack:
        cluster, scheduler = "local:2", None
        if victim == "scheduler":
            cluster, scheduler = _cluster(out, stack)
        words = [sys.executable, "-m", "tests.experiments.sweep.cheap", str(out), str(COUNT), "--cluster", cluster]
        driver = subprocess.Popen(words, cwd=ROOT, stderr=subprocess.PIPE, text=True)
        stack.callback(_end, driver)
        _wait(driver, out, chance.randrange(COUNT - 4))
        time.sleep(chance.uniform(0, 0.05))
        if victim == "driver":
            driver.kill()
        elif scheduler is not None:
            scheduler.kill()
        else:
            _kill_a_worker(driver, chance)
        said = driver.communicate(timeout=PATIENCE_S)[1]
    faults = _faults_of_the_driver(victim, driver.returncode, said)
    kept = KeptCases(out / "cases")
    before = {path.name: path.read_bytes() for path in kept.folder.glob("*.json")}
    swept = sweep(out, COUNT, resume=True)
    after = {path.name: path.read_bytes() for path in kept.folder.glob("*.json")}
    if swept.known != len(before):
        faults.append(f"{len(before)} were kept, {swept.known} known")
    if not before.items() <= after.items():
        faults.append("a case that was done was written again")
    wanted = {f"{case.identity}.json" for case in cases(COUNT)}
    if after.keys() != wanted:
        faults.append(f"lost {len(wanted - after.keys())}, too many {len(after.keys() - wanted)}")
    found = {case.what.number: data["square"] for case, data in swept.results()}
    if found != {number: number**2 for number in range(COUNT)}:
        faults.append(f"results: {found}")
    return faults


def _faults_of_the_driver(victim: str, status: int, said: str) -> list[str]:
    if victim == "worker":  # is replaced: nobody notices
        return [] if status == 0 else [f"exit status {status}: {said}"]
    if victim == "scheduler":  # exit status 0 where it had just ended
        return [] if status in (0, 3) and "Traceback" not in said else [f"exit status {status}: {said}"]
    return [] if status in (0, -signal.SIGKILL) else [f"exit status {status}: {said}"]


def _wait(driver: subprocess.Popen, out: Path, count: int) -> None:
    """Wait until so many cases are kept, or for a moment of the start."""
    end = time.monotonic() + PATIENCE_S
    while driver.poll() is None and len(list((out / "cases").glob("*.json"))) < count + 1:
        assert time.monotonic() < end, "nothing is done"
        time.sleep(0.002)


def _kill_a_worker(driver: subprocess.Popen, chance: random.Random) -> None:
    """Kill one of the driver's workers: its children that have imported something."""
    with suppress(psutil.Error):  # it has just come to its end
        children = psutil.Process(driver.pid).children()
        workers = [child for child in children if "spawn_main" in " ".join(child.cmdline())]
        if children:
            chance.choice(workers or children).kill()


def _cluster(out: Path, stack: ExitStack) -> tuple[str, subprocess.Popen]:
    """Start a scheduler and two workers; return its address and process."""
    about = out / "scheduler.json"
    common = ["--host", "127.0.0.1", "--no-dashboard", "--scheduler-file", str(about)]
    quiet = {"cwd": ROOT, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    module = [sys.executable, "-m", "distributed.cli.dask_{}"]
    scheduler = subprocess.Popen([*module[:2], module[2].format("scheduler"), "--port", "0", *common], **quiet)
    stack.callback(_end, scheduler)
    end = time.monotonic() + PATIENCE_S
    while not about.exists():
        assert scheduler.poll() is None and time.monotonic() < end
        time.sleep(0.01)
    for name in ("one", "two"):
        more = ["--nthreads", "1", "--no-nanny", "--name", name, "--local-directory", str(out / name)]
        stack.callback(_end, subprocess.Popen([*module[:2], module[2].format("worker"), *common, *more], **quiet))
    while True:
        assert scheduler.poll() is None
        with suppress(ValueError):  # it has not been written to its end
            return json.loads(about.read_text(encoding="utf-8"))["address"], scheduler
        time.sleep(0.01)


def _end(process: subprocess.Popen) -> None:
    process.kill()
    process.wait()
    if process.stderr is not None:
        process.stderr.close()


def main() -> None:
    moments, seed = int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 1
    chance, tally = random.Random(seed), Counter[str]()
    with tempfile.TemporaryDirectory() as folder:
        for number in range(moments):
            victim = VICTIMS[number % len(VICTIMS)]
            faults = kill_in(victim, Path(folder) / str(number), chance)
            tally[victim] += 1
            print(number, victim, faults or "nothing lost, nothing doubled", flush=True)
            assert not faults, f"seed {seed}"
    told = ", ".join(f"{count} of a {victim}" for victim, count in tally.items())
    print(f"{moments} kills at random moments ({told}): all {COUNT} cases of each run were there once.")


if __name__ == "__main__":
    main()
