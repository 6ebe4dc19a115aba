"""The section of a study's page on the measures that predict the ratings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ..parts import PageChart, PageTable
from ..words import interval, plain, signed
from .charts import scatter_chart

_HEADS = (
    ("metric", ""), ("r", "within people"), ("95 %", ""), ("r of ranks", ""),
    ("error removed", "%"), ("95 %", ""), ("best in", "%"),
)  # fmt: skip
_CAPTION = "Metrics of the pictures against the ratings"


def prediction_of(data: Mapping[str, Any] | None, measure: Mapping[str, Any]) -> Mapping[str, Any] | None:
    """Return the content of the section; None where nothing was measured.

    data: as in analysis.json. measure: the scale of the ratings.
    """
    if data is None:
        return None
    titles = {one["name"]: one["title"] for one in data["measures"]}
    charts = [
        PageChart.of(
            titles[name], scatter_chart(points, titles[name], measure), f"{titles[name]} against {measure['title']}"
        )
        for name, points in data["points"].items()
    ]
    return {
        "sentences": data["sentences"],
        "table": PageTable.of(_CAPTION, *prediction_lines(data["measures"])) if data["measures"] else None,
        "charts": charts,
    }


def prediction_lines(measures: Sequence[Mapping[str, Any]]) -> tuple[tuple[tuple[str, str], ...], list[list[str]]]:
    """Return heads (label, unit) and lines of the table of measures, the best first."""
    return _HEADS, [
        [
            one["title"],
            signed(one["r"]),
            interval(one["low"], one["high"]),
            signed(one["rank_r"]),
            _percent(one["skill"]),
            f"{_percent(one['skill_low'])} .. {_percent(one['skill_high'])}",
            _percent(one["best"]),
        ]
        for one in measures
    ]


def _percent(share: float | None) -> str:
    return plain(None if share is None else 100 * share, 0)
