"""Tests of this folder run in Monado's root, by a second pytest.

What becomes of them there becomes of them here.

Outside, `Inner` starts the second pytest, asks it for one test after the other and hands out what
it reports. Inside, `Reporter` runs what is asked for and tells it, line by line, through pipes.
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

PIPES = "HMDWARP_TEST_PIPES"  # the numbers of their ends to read from and to write to; only set inside
SILENCE_S = 180.0  # longer than any test here may take


@attrs.frozen
class Outcome:
    """What became of one test. outcome: "passed", "failed" or "skipped". text: why."""

    outcome: str
    text: str = ""


class Inner:
    """A pytest in `root` that runs tests of some files, each when it is asked to.

    Errors: none; a test it does not tell of counts as failed, with what it said.
    """

    def __init__(self, root: Path, files: list[str]) -> None:
        self._said = tempfile.TemporaryFile()  # noqa: SIM115 (closed with the process)
        (self._told, tells), (asked, self._asks) = os.pipe(), os.pipe()
        self._bytes = b""
        command = [f"{PIPES}={asked},{tells}", "python3", "-m", "pytest", "-p", "no:cacheprovider", "-p", "no:xdist"]
        try:
            self._process = subprocess.Popen(
                entered(root, [*command, *files]), pass_fds=[asked, tells], stdin=subprocess.DEVNULL, stdout=self._said,
                stderr=subprocess.STDOUT,
            )  # fmt: skip
        finally:
            os.close(asked)
            os.close(tells)

    @property
    def has_ended(self) -> bool:
        """Whether it ended by itself, as a run that hangs ends its process."""
        return self._process.poll() is not None

    def outcome_of(self, name: str, following: str | None) -> Outcome:
        """Have a test run; following: the next one here, with which it shares fixtures."""
        with suppress(BrokenPipeError):  # it has ended: no line comes
            os.write(self._asks, f"{json.dumps([name, following])}\n".encode())
        line = self._line()
        return Outcome("failed", self._silent()) if line is None else Outcome(**json.loads(line))

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
        """Let it end: no process stays behind for tests that count them."""
        os.close(self._asks)
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(SILENCE_S)
        self._process.kill()
        self._process.wait()
        os.close(self._told)
        self._said.close()


class Reporter:
    """A plugin of the pytest inside.

    asked, tells: pipes for the names of tests and for what became of them.
    """

    def __init__(self, asked: int, tells: int) -> None:
        for pipe in (asked, tells):  # what a test starts must not keep them open
            os.set_inheritable(pipe, False)
        self._asked, self._tells = asked, tells
        self._worst: dict[str, Outcome] = {}

    def pytest_runtestloop(self, session: pytest.Session) -> bool | None:
        """Run tests in the order in which they are asked for."""
        if session.testsfailed:
            return None  # a file could not be read, which pytest's own loop says
        items = {item.nodeid: item for item in session.items}
        with os.fdopen(self._asked, encoding="utf-8") as asked:
            for line in asked:
                name, following = json.loads(line)
                item = items[name]
                item.config.hook.pytest_runtest_protocol(item=item, nextitem=items.get(following))
        return True

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Of the three steps of a test the first that did not pass counts.

        After the last one it is told.
        """
        worst = self._worst.setdefault(report.nodeid, Outcome("passed"))
        if worst.outcome == "passed" and report.outcome != "passed":
            self._worst[report.nodeid] = Outcome(report.outcome, _why(report))
        if report.when == "teardown":
            outcome = self._worst.pop(report.nodeid)
            os.write(self._tells, f"{json.dumps(attrs.asdict(outcome))}\n".encode())


def _why(report: pytest.TestReport) -> str:
    if report.skipped:
        return (
            report.longrepr[2].removeprefix("Skipped: ") if isinstance(report.longrepr, tuple) else report.longreprtext
        )
    sections = "".join(f"\n--- {title} ---\n{text}" for title, text in report.sections)
    return f"{report.longreprtext}{sections}"
