"""What a bench says of rows that its client cannot run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ...client.classes import Client
from ...metrics import PRIMARY, metrics
from ...report.bench import cases

Row = Mapping[str, Any]


def left_out_notes(rows: Sequence[Row], client: Client) -> list[str]:
    """Return which methods the front and the choice leave out, and what they would gain.

    rows: of bench.json. Empty if the client can run all of them.
    """
    lacking = [row for row in rows if row["lacks"]]
    if not lacking:
        return []
    names = ", ".join(dict.fromkeys(_name(row) for row in lacking))
    notes = [f"Not in the front: client '{client.name}' ({client.summary}) cannot run {names}. --client names another."]
    for case in cases(rows):
        ordered = [row for row in case.ordered() if row["quality"][PRIMARY]["mean"] is not None]
        best = next((row for row in ordered if not row["lacks"]), None)
        if best is None or not ordered[0]["lacks"]:
            continue
        gain = f"{case.label}: a client that can run {_name(ordered[0])} would have {_figures(ordered[0])}"
        notes.append(f"{gain}, where {_name(best)} has {_figures(best)}; {ordered[0]['lacks']}.")
    return notes


def _name(row: Row) -> str:
    return row["warp"] if row["fill"] == "none" else f"{row['warp']} + {row['fill']}"


def _figures(row: Row) -> str:
    total = row["time_ms"]["total"]["median"]
    return f"{metrics.get(PRIMARY).short_figure.label} {row['quality'][PRIMARY]['mean']:.3f} in {total:.2f} ms"
