"""Control over Python's garbage collector, and a record of its pauses."""

from __future__ import annotations

import gc
import time
from typing import Any


class GarbageControl:
    """Collect garbage only between pictures.

    What exists on entry (modules, shaders, the scene) is frozen, so that no collection scans it.
    """

    def __init__(self, on: bool = True) -> None:
        """Configure it. on: False leaves collection to Python, for comparison."""
        self._on = on
        self._was_enabled = False

    def __enter__(self) -> GarbageControl:
        self._was_enabled = gc.isenabled()
        if self._on:
            gc.collect()
            gc.freeze()
            gc.disable()
        return self

    def between(self) -> None:
        """Collect the youngest generation, to which a refresh adds some hundred objects.

        Call between pictures.
        """
        if self._on:
            gc.collect(0)

    def __exit__(self, *_: object) -> None:
        if self._on:
            gc.unfreeze()
            if self._was_enabled:
                gc.enable()


class Pauses:
    """Number and time of collections between `start` and `stop`, by generation.

    Costs about a microsecond for each collection.
    """

    def __init__(self) -> None:
        self._runs, self._total_ns, self._longest_ns = [0, 0, 0], 0, 0
        self._began_ns: int | None = None

    def start(self) -> None:
        """Count from now on."""
        gc.callbacks.append(self._notice)

    def stop(self) -> None:
        """Stop counting; safe to call twice, or without start."""
        if self._notice in gc.callbacks:
            gc.callbacks.remove(self._notice)

    def _notice(self, phase: str, about: dict[str, int]) -> None:
        if phase == "start":
            self._began_ns = time.perf_counter_ns()
        elif self._began_ns is not None:
            took_ns, self._began_ns = time.perf_counter_ns() - self._began_ns, None
            self._runs[about["generation"]] += 1
            self._total_ns += took_ns
            self._longest_ns = max(self._longest_ns, took_ns)

    def as_dict(self) -> dict[str, Any]:
        """Return its part of summary.json.

        Counts from the youngest generation to the oldest, times in ms.
        """
        return {"collections": self._runs, "total_ms": self._total_ns * 1e-6, "longest_ms": self._longest_ns * 1e-6}
