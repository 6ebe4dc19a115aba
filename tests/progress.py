"""Progress of a run of the tests: how much is done, and about how long the rest takes."""

from __future__ import annotations

import time
from collections import deque

import pytest

LINE_EVERY_S = 20.0
RECENT = 400  # tests whose mean duration tells what the rest takes: slow ones ran first


class Progress:
    """Counts finished tests where results are collected: here, or of all workers."""

    def __init__(self, config: pytest.Config) -> None:
        self._workers = max(1, getattr(config.option, "numprocesses", 0) or 0)
        self._terminal = config.pluginmanager.get_plugin("terminalreporter")
        self._total = self._done = 0
        self._recent: deque[float] = deque(maxlen=RECENT)
        self._spent_s, self._told_s = 0.0, time.monotonic()

    def pytest_collection_finish(self, session: pytest.Session) -> None:
        self._total = len(session.items)

    @pytest.hookimpl(optionalhook=True)
    def pytest_xdist_node_collection_finished(self, node: object, ids: list[str]) -> None:
        self._total = len(ids)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self._spent_s += report.duration
        if report.when != "teardown":
            return
        self._recent.append(self._spent_s)
        self._spent_s, self._done = 0.0, self._done + 1
        now_s = time.monotonic()
        if self._total and now_s - self._told_s >= LINE_EVERY_S:
            self._told_s = now_s
            self._terminal.write_line(f"\n{self.line()}")

    def line(self) -> str:
        """Return how far the run is, in words."""
        left_s = sum(self._recent) / len(self._recent) * (self._total - self._done) / self._workers
        left = f"{left_s:.0f} s" if left_s < 90 else f"{left_s / 60:.0f} min"
        return f"{self._done} of {self._total} tests, about {left} to go"
