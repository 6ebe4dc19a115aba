"""What the pages show of refreshes that got no new picture."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..metrics import Figure
from .charts import Series, time_series
from .parts import Chart, Tile

_SHARE = Figure("stale_share", "Missed refreshes", "%", 1, 100)


def miss_tile(entry: Mapping[str, Any], others: Sequence[tuple[str, Mapping[str, Any]]] = ()) -> Tile:
    """Return the tile of a run.

    entry: `miss` of summary.json. others: name and entry of each run beside it.
    """
    beside = "; ".join(f"{name}: {_SHARE.text(one['stale_share'])}, {_tail(one)}" for name, one in others)
    return Tile(_SHARE.label, _SHARE.unit, _SHARE.text(entry["stale_share"]), _tail(entry), beside or None)


def _tail(entry: Mapping[str, Any]) -> str:
    return f"at most {entry['longest_stale']} in a row; judder {entry['judder_deg']:.3f} deg RMS"


def miss_chart(budget_ms: float, runs: Sequence[tuple[str, Sequence[Mapping[str, Any]]]]) -> Chart:
    """Return the chart of the client's time against its budget.

    runs: name and rows of each, at most two, as misses.csv's.
    """
    lines = [
        Series.of(name, rows, "took_ms", ticks_s=[row["time_s"] for row in rows if row["stale"]]) for name, rows in runs
    ]
    times_s = np.array([row["time_s"] for row in runs[0][1]])
    lines.append(Series("budget", times_s, np.full(len(times_s), budget_ms)))
    return Chart("Client's time for a picture; ticks: missed refreshes", time_series(lines, "ms"))
