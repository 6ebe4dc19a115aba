"""What the pages show of refreshes that got no new picture."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from .charts import Series, time_series
from .parts import Chart, Tile
from .tables import MISS_FIGURES, miss_texts


def miss_tile(entry: Mapping[str, Any], others: Sequence[tuple[str, Mapping[str, Any]]] = ()) -> Tile:
    """Return the tile of a run.

    entry: `miss` of summary.json. others: name and entry of each run beside it.
    """
    share, longest, judder = miss_texts(entry)
    beside = "; ".join(f"{name}: {miss_texts(one)[0]}" for name, one in others)
    note = f"at most {longest} in a row; judder {judder} deg RMS"
    return Tile(MISS_FIGURES[0].label, MISS_FIGURES[0].unit, share, note, beside or None)


def miss_chart(budget_ms: float, runs: Sequence[tuple[str, Sequence[Mapping[str, Any]]]]) -> Chart:
    """Return the chart of the client's time against its budget.

    runs: name and rows of each, at most three, as misses.csv's; no rows for one that is always in
    time, whose place the budget takes, so that the others keep theirs.
    """
    lines = [
        Series.of(name, rows, "took_ms", ticks_s=[row["time_s"] for row in rows if row["stale"]]) for name, rows in runs
    ]
    times_s = np.array([row["time_s"] for row in runs[0][1]])
    free = next((number for number, (_, rows) in enumerate(runs) if not rows), len(runs))
    lines[free : free + 1] = [Series("budget", times_s, np.full(len(times_s), budget_ms))]
    return Chart("Client's time for a picture; ticks: missed refreshes", time_series(lines, "ms"))
