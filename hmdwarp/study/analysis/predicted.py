"""What was measured while the pictures were shown, joined with the ratings they got."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import attrs

from ..prediction import predict

_DRAWN = 4  # measures that get a chart


def predicted(rows: Sequence[Mapping[str, Any]], scale: str) -> dict[str, Any] | None:
    """Which measure goes with the ratings best, as plain data with its sentences; None where nothing was measured."""
    found = predict(rows, scale) if any(row["scale"] == scale for row in rows) else None
    if found is None:
        return None
    drawn = [one.name for one in found.measures[:_DRAWN]]
    return {
        "sentences": found.sentences(),
        "measures": [{key: _plain(value) for key, value in attrs.asdict(one).items()} for one in found.measures],
        "left_out": [list(pair) for pair in found.left_out],
        "resamples": found.resamples,
        "seed": found.seed,
        "points": {name: _points(rows, scale, name) for name in drawn},
    }


def _points(rows: Sequence[Mapping[str, Any]], scale: str, name: str) -> list[dict[str, Any]]:
    there = (
        row for row in rows if row["scale"] == scale and row.get("value") is not None and row.get(name) is not None
    )
    return [{"participant": row["participant"], "x": row[name], "y": row["value"]} for row in there]


def _plain(value: Any) -> Any:
    """JSON has no NaN."""
    return (
        None
        if isinstance(value, float) and not math.isfinite(value)
        else list(value)
        if isinstance(value, tuple)
        else value
    )
