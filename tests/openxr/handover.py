"""Tests of this folder run in Monado's root, by a second pytest.

What becomes of them there becomes of them here.

Outside, `Inner` starts the second pytest for the tests of one file and hands out what it reports.
Inside, `Reporter` tells it, line by line, through a pipe.
"""

from __future__ import annotations

import json
import os
import select
import subprocess
import tempfile
from contextlib import suppress
from pathlib import Path

import attrs
import pytest

from .root import entered

PIPE = "HMDWARP_TEST_REPORTS"  # the number of the pipe's end to write to; only set inside
SILENCE_S = 180.0  # longer than any test here may take


@attrs.frozen
class Outcome:
    """What became of one test. outcome: "passed", "failed" or "skipped". text: why."""

    outcome: str
    text: str = ""


class Inner:
    """A pytest in `root` that runs the tests named.

    Errors: none; a test it does not tell of counts as failed, with what it said.
    """

    def __init__(self, root: Path, names: list[str]) -> None:
        self._said = tempfile.TemporaryFile()  # noqa: SIM115 (closed with the process)
        self._told, tells = os.pipe()
        self._bytes, self._outcomes, self._names = b"", {}, set(names)
        command = [f"{PIPE}={tells}", "python3", "-m", "pytest", "-p", "no:cacheprovider", "-p", "no:xdist", *names]
        try:
            self._process = subprocess.Popen(
                entered(root, command),
                pass_fds=[tells],
                stdin=subprocess.DEVNULL,
                stdout=self._said,
                stderr=subprocess.STDOUT,
            )
        finally:
            os.close(tells)

    def outcome_of(self, name: str) -> Outcome:
        """Wait for it."""
        while name not in self._outcomes:
            line = self._line()
            if line is None:
                return Outcome("failed", self._silent())
            told = json.loads(line)
            self._outcomes[told["name"]] = Outcome(told["outcome"], told["text"])
        if self._names <= self._outcomes.keys():
            self._reap()
        return self._outcomes[name]

    def _reap(self) -> None:
        """It has told all there was to tell: no process stays behind for tests that count them."""
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(SILENCE_S)
        self.close()

    def _silent(self) -> str:
        """Why nothing more is told."""
        try:
            ended = f"ended with status {self._process.wait(1)}"
        except subprocess.TimeoutExpired:
            self._process.kill()
            ended = f"has told nothing for {SILENCE_S:g} s"
        return f"the pytest in Monado's root {ended}. It said:\n{self.said()}"

    def _line(self) -> bytes | None:
        while b"\n" not in self._bytes:
            ready, _, _ = select.select([self._told], [], [], SILENCE_S)
            more = os.read(self._told, 1 << 16) if ready else b""
            if not more:
                return None
            self._bytes += more
        line, self._bytes = self._bytes.split(b"\n", 1)
        return line

    def said(self) -> str:
        """The end of its own output."""
        self._said.seek(0)
        return self._said.read().decode(errors="replace")[-8000:]

    def close(self) -> None:
        """End it. May be called twice."""
        if not self._said.closed:
            self._process.kill()
            self._process.wait()
            os.close(self._told)
            self._said.close()


class Reporter:
    """A plugin of the pytest inside."""

    def __init__(self, pipe: int) -> None:
        os.set_inheritable(pipe, False)  # what a test starts must not keep it open
        self._pipe = pipe
        self._worst: dict[str, Outcome] = {}

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Of the three steps of a test the first that did not pass counts.

        After the last one it is told.
        """
        worst = self._worst.setdefault(report.nodeid, Outcome("passed"))
        if worst.outcome == "passed" and report.outcome != "passed":
            self._worst[report.nodeid] = Outcome(report.outcome, _why(report))
        if report.when == "teardown":
            outcome = self._worst.pop(report.nodeid)
            line = json.dumps({"name": report.nodeid, "outcome": outcome.outcome, "text": outcome.text})
            os.write(self._pipe, f"{line}\n".encode())


def _why(report: pytest.TestReport) -> str:
    if report.skipped:
        return (
            report.longrepr[2].removeprefix("Skipped: ") if isinstance(report.longrepr, tuple) else report.longreprtext
        )
    sections = "".join(f"\n--- {title} ---\n{text}" for title, text in report.sections)
    return f"{report.longreprtext}{sections}"
