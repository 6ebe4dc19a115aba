"""What Python's garbage collector does to the pictures of a live run.

Whenever it likes, and between them.
"""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from rich.table import Table

BUDGET_MS = 1e3 / 90
WARM = 60
WHEN = {"whenever it likes": False, "between the pictures": True}


class Pauses:
    """Of each refresh what it took, and what of that was collecting.

    Between begin() and end(), and beside (after the hand-over).
    """

    def __init__(self) -> None:
        self.refreshes_ms: list[float] = []
        self.collecting_ms: list[float] = []
        self.pauses_ms: list[tuple[int, float]] = []
        self._started_ns = self._began_ns = 0
        self._within_ms = 0.0

    def begin(self) -> None:
        self._within_ms, self._started_ns = 0.0, time.perf_counter_ns()

    def end(self) -> None:
        if self._started_ns:
            self.refreshes_ms.append((time.perf_counter_ns() - self._started_ns) * 1e-6)
            self.collecting_ms.append(self._within_ms)

    def notice(self, phase: str, about: Mapping[str, int]) -> None:
        """For gc.callbacks."""
        if phase == "start":
            self._began_ns = time.perf_counter_ns()
            return
        took_ms = (time.perf_counter_ns() - self._began_ns) * 1e-6
        self._within_ms += took_ms
        if len(self.refreshes_ms) >= WARM:
            self.pauses_ms.append((about["generation"], took_ms))


def table_of(drive: Callable[..., None], frames: int, chosen: dict[str, Any]) -> Table:
    """drive: as bench_live.drive without the GPU."""
    head = (
        "collecting",
        "pauses by generation",
        "longest ms",
        "p99",
        "ms a refresh",
        "refresh median",
        "p99",
        "longest",
        "late by it",
    )
    how = f"{frames} refreshes ({chosen['warp']} + {chosen['fill']})"
    title = f"Garbage collection in {how}; late by it: over {BUDGET_MS:.1f} ms (90 Hz)"
    table = Table(*head, title=f"{title} with collecting, not without")
    for name, between in WHEN.items():
        pauses = Pauses()
        gc.collect()
        gc.callbacks.append(pauses.notice)
        try:
            drive(WARM + frames, pauses.begin, pauses.end, collect=between, **chosen)
        finally:
            gc.callbacks.remove(pauses.notice)
        table.add_row(name, *_told(pauses))
    return table


def _told(pauses: Pauses) -> list[str]:
    took = np.array([ms for _, ms in pauses.pauses_ms] or [0.0])
    by_generation = " / ".join(str(sum(one == generation for one, _ in pauses.pauses_ms)) for generation in range(3))
    refreshes, collecting = (np.array(values[WARM:]) for values in (pauses.refreshes_ms, pauses.collecting_ms))
    rendered = int(((refreshes > BUDGET_MS) & (refreshes - collecting <= BUDGET_MS)).sum())
    numbers = (
        took.max(),
        np.percentile(took, 99),
        took.sum() / len(refreshes),
        *np.percentile(refreshes, (50, 99)),
        refreshes.max(),
    )
    return [by_generation, *(f"{value:.3f}" for value in numbers), str(rendered)]
