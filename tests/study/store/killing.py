"""Programs that are killed at a given instant.

Forked from one that has everything imported, so that thirty of them take seconds.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

from .sessions import child


class Killing:
    """code: Python that defines job(folder).

    told(text) in it tells a line, which is on its way when told returns. A context manager.
    """

    def __init__(self, code: str) -> None:
        head = "from tests.study.store.killing import nursery, told\n"
        self._process = child(f"{head}{code}\nnursery(job)", stdin=subprocess.PIPE)

    def __enter__(self) -> Killing:
        return self

    def __exit__(self, *_: object) -> None:
        self._process.kill()
        self._process.communicate()

    def job(self, folder: Path, seconds: float | None) -> list[str]:
        """What it told until it was killed, by SIGKILL that long after its start.

        None lets it come to its end.
        """
        self._process.stdin.write(f"{-1 if seconds is None else seconds} {folder}\n")
        self._process.stdin.flush()
        lines = []
        while (line := self._process.stdout.readline().rstrip("\n")) not in ("dead", ""):
            lines.append(line)
        assert line == "dead", self._process.stderr.read()
        return lines


def told(text: str) -> None:
    """One write, which a pipe takes whole or not at all."""
    os.write(1, f"{text}\n".encode())


def nursery(job: Callable[[Path], None]) -> None:
    """In the child: forks a job for each line that comes, and kills it when its time is up."""
    for line in sys.stdin:
        seconds, _, folder = line.rstrip("\n").partition(" ")
        pid = os.fork()
        if not pid:
            job(Path(folder))
            os._exit(0)
        if float(seconds) >= 0:
            time.sleep(float(seconds))
            os.kill(pid, signal.SIGKILL)
        _, status = os.waitpid(pid, 0)
        if status and not os.WIFSIGNALED(status):
            sys.exit(f"the job ended with {status}")
        told("dead")
