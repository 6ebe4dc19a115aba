"""Cases that cost nearly nothing, and a program that runs a set of them.

    python -m tests.experiments.sweep.cheap OUT COUNT [--resume] [--cluster WHERE]

The real sweep with the real Dask; only what a case computes is cheap. A case leaves a line in
`OUT/ran` each time it is run. Case number 13 of `deadly` ends its process.
"""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import attrs

from hmdwarp.base import HmdwarpError, InputError
from hmdwarp.experiments.sweep import KeptOptions, Result, SweepCase, Swept, run_cases

SECONDS = 0.02


@attrs.frozen
class Task:
    number: int
    kind: str = "plain"
    file: str = ""  # a file that crosses with the case


@attrs.frozen
class Cheap:
    """Squares numbers."""

    log: Path

    @contextmanager
    def __call__(self) -> Iterator:
        yield self._run

    def _run(self, case: SweepCase, step) -> Result:
        with self.log.open("a", encoding="utf-8") as log:
            log.write(f"{case.what.number}\n")
        if case.what.kind == "deadly" and case.what.number == 13:
            os.kill(os.getpid(), signal.SIGKILL)
        if case.what.kind == "wrong" and case.what.number == 13:
            raise InputError("13 is no number for this")
        time.sleep(SECONDS)
        text = Path(case.what.file).read_text(encoding="utf-8") if case.what.file else ""
        return Result({"square": case.what.number**2, "text": text, "pid": os.getpid()})


def cases(count: int, kind: str = "plain", file: str = "") -> list[SweepCase]:
    tasks = [Task(number, kind, file) for number in range(count)]
    return [SweepCase.of("cheap", f"number {task.number}", task) for task in tasks]


def sweep(out: Path, count: int, kind: str = "plain", file: str = "", say=lambda text: None, **options) -> Swept:
    out.mkdir(exist_ok=True)
    return run_cases(Cheap(out / "ran"), cases(count, kind, file), out, KeptOptions(**options), say=say)


def main() -> None:
    out, count, *rest = sys.argv[1:]
    cluster = rest[rest.index("--cluster") + 1] if "--cluster" in rest else None
    try:
        sweep(Path(out), int(count), resume="--resume" in rest, cluster=cluster).raise_failures()
    except HmdwarpError as error:
        print(error, file=sys.stderr)
        sys.exit(error.exit_status)


if __name__ == "__main__":
    main()
