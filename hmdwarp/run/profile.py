"""Where a replay's CPU time goes: a table, and trace events for Perfetto (ui.perfetto.dev)."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext

# Parts, in the order of the table; stages of the passes stand where SHOWING does.
SET_UP, DRAWING, SHOWING, TRUTH = "set-up", "drawing", "passes, besides", "truth"
COMPARED, READING, ALIKE = "compared warps", "reading back", "FLIP and SSIM"
WORKERS, BESIDE, RESULTS = "measuring processes", "the loop besides", "results"
_BEFORE, _AFTER = (SET_UP, DRAWING), (SHOWING, TRUTH, COMPARED, READING, ALIKE, WORKERS, BESIDE, RESULTS)


class Profile:
    """Counts CPU seconds of all threads by part; a part within another one is not in the other.

    The GPU is waited for where parts change, so that what llvmpipe's threads draw counts where it
    belongs. SET_UP counts from the start of the process.
    """

    def __init__(self) -> None:
        self.finish: Callable[[], object] = lambda: None  # waits for the GPU, once there is one
        self._spent_ns: dict[str, int] = {}
        self._parts = [SET_UP]
        self._since_ns = 0
        self._events: list[dict[str, object]] = []

    def enter(self, name: str) -> None:
        """Count what is in no part as this from now on."""
        self._count()
        self._parts[0] = name

    @contextmanager
    def part(self, name: str) -> Iterator[None]:
        """Count what runs inside as this part."""
        self._count()
        self._parts.append(name)
        started_ns = time.perf_counter_ns()
        try:
            yield
        finally:
            self._count()
            self._parts.pop()
            took_ns = time.perf_counter_ns() - started_ns
            where = {"pid": 1, "tid": 1, "ts": started_ns / 1e3, "dur": took_ns / 1e3}
            self._events.append({"ph": "X", "name": name, "cat": "cpu", **where})

    def stage(self, name: str) -> AbstractContextManager[None]:
        """Count a stage of the passes that are shown; those of other plans belong to their part."""
        return self.part(name) if self._parts[-1] == SHOWING else nullcontext()

    def _count(self) -> None:
        self.finish()
        now_ns = time.process_time_ns()
        part = self._parts[-1]
        self._spent_ns[part] = self._spent_ns.get(part, 0) + now_ns - self._since_ns
        self._since_ns = now_ns

    def seconds(self) -> dict[str, float]:
        """Return CPU seconds by part so far, those of ended child processes included."""
        self._count()
        times = os.times()
        spent = {name: ns * 1e-9 for name, ns in self._spent_ns.items()}
        spent[WORKERS] = times.children_user + times.children_system
        stages = [name for name in spent if name not in (*_BEFORE, *_AFTER)]
        return {name: spent[name] for name in (*_BEFORE, *stages, *_AFTER) if name in spent}

    def table(self, refreshes: int) -> str:
        """Return the table, in Markdown."""
        spent = self.seconds()
        whole = sum(spent.values())
        lines = ["| part | CPU s | % | ms a refresh |", "| --- | ---: | ---: | ---: |"]
        for name, s in {**spent, "all": whole}.items():
            lines.append(f"| {name} | {s:.2f} | {100 * s / whole:.1f} | {1e3 * s / refreshes:.1f} |")
        return "\n".join(lines)

    def events(self) -> str:
        """Return the parts as trace events: JSON."""
        return json.dumps(self._events)
