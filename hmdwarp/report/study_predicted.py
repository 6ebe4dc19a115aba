"""The section of a study's page on what predicts the ratings."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .bench_page import Cell, Line, PageChart, PageTable
from .study_charts import scatter_chart
from .study_words import interval, plain, signed

_HEADS = (
    ("measure", ""), ("r", "within people"), ("95 %", ""), ("r of ranks", ""), ("error taken off", "%"), ("95 %", ""), ("best in", "%"),
)  # fmt: skip


def prediction_of(data: Mapping[str, Any] | None, measure: Mapping[str, Any]) -> Mapping[str, Any] | None:
    """What the template shows; None where nothing was measured. data: as analysis.json has it; measure: what the ratings are on."""
    if data is None:
        return None
    titles = {one["name"]: one["title"] for one in data["measures"]}
    charts = [
        PageChart(
            titles[name],
            (("", scatter_chart(points, titles[name], measure), f"{titles[name]} against {measure['title']}"),),
        )
        for name, points in data["points"].items()
    ]
    return {
        "sentences": data["sentences"],
        "table": _table(data["measures"]) if data["measures"] else None,
        "charts": charts,
    }


def _table(measures: list[Mapping[str, Any]]) -> PageTable:
    lines = []
    for one in measures:
        texts = [
            one["title"],
            signed(one["r"]),
            interval(one["low"], one["high"]),
            signed(one["rank_r"]),
            _percent(one["skill"]),
            f"{_percent(one['skill_low'])} .. {_percent(one['skill_high'])}",
            _percent(one["best"]),
        ]
        lines.append(Line(tuple(Cell(text, number > 0) for number, text in enumerate(texts))))
    return PageTable("Measures of the pictures against the ratings", _HEADS, tuple(lines))


def _percent(share: float | None) -> str:
    return plain(None if share is None else 100 * share, 0)
