"""How long Python's garbage collector held the pictures up."""

from __future__ import annotations

import gc
import time
from collections.abc import Mapping
from typing import Any


class Pauses:
    """Counts collections and their time from `start` to `stop`, by generation. Costs about a microsecond for each collection."""

    def __init__(self) -> None:
        self._runs, self._total_ns, self._longest_ns = [0, 0, 0], 0, 0
        self._began_ns: int | None = None

    def start(self) -> None:
        """From now on."""
        gc.callbacks.append(self._notice)

    def stop(self) -> None:
        """May be called twice, and without start."""
        if self._notice in gc.callbacks:
            gc.callbacks.remove(self._notice)

    def _notice(self, phase: str, about: Mapping[str, int]) -> None:
        if phase == "start":
            self._began_ns = time.perf_counter_ns()
        elif self._began_ns is not None:
            took_ns, self._began_ns = time.perf_counter_ns() - self._began_ns, None
            self._runs[about["generation"]] += 1
            self._total_ns += took_ns
            self._longest_ns = max(self._longest_ns, took_ns)

    def as_dict(self) -> dict[str, Any]:
        """For summary.json: collections from the youngest generation to the oldest, their time in ms."""
        return {"collections": self._runs, "total_ms": self._total_ns * 1e-6, "longest_ms": self._longest_ns * 1e-6}
