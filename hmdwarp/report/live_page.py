"""report.html of a live run: as a replay's, without a truth, with figures of its own."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..metrics import Figure, Input, metrics, metrics_in_order
from .charts import Series, time_series
from .frame_ways import timeline_svg
from .live_lines import budget_rows
from .miss_parts import miss_tile
from .parts import CLOCK_NAMES, Chart, Tile, environment
from .source_texts import drawing_text, eyes_text, source_facts
from .tables import TIME_FIGURES, Summary
from .transit import coding_rows, frame_rows, response_rows
from .words import listed

Column = Callable[[str], NDArray[np.float64]]

_MS = Figure("", "", "ms", 1)
_SHORT_MS = Figure("", "", "ms", 2)


def render_live_report(summary: Summary, column: Column, *, command: str) -> str:
    """Return the text of report.html.

    summary: as summary.json, with `live`. column(name): the numbers behind it over time, NaN where
    there is none: time_s, age_ms, pose_age_ms, period_ms, busy_ms, angular_speed_deg_s,
    linear_speed_m_s, hole_share/0, hole_share/1. command: as the user typed it.
    """
    live = summary["live"]
    template = environment().get_template("live.html")
    return template.render(
        summary=summary,
        live=live,
        sources=source_facts(summary),
        command=command,
        about=[(name, text) for name, text in live["about"].items() if text],
        notes=summary["notes"],
        tiles=_tiles(summary),
        budget=[
            (what, median, tail, f"{share:.0%}", min(100.0, 100 * share))
            for what, median, tail, share in budget_rows(summary)
        ],
        over=f"{live['over'] / max(1, live['timed']):.1%}",
        changes=[_change(one) for one in live["changes"]],
        notices=list(live["notices"].items()),
        collector=live["garbage_collector"],
        charts=_charts(summary, column),
        filled=[],
        models=[],
        response=response_rows(summary),
        frames=frame_rows(summary),
        coding=coding_rows(summary),
        timeline=timeline_svg((summary.get("link") or {}).get("timeline") or ()),
        clock=CLOCK_NAMES[summary["clock"]],
        errors=listed([metric.short_label for metric in metrics_in_order() if Input.TRUTH in metric.needs]),
    )


def _tiles(summary: Summary) -> list[Tile]:
    live, holes, total = summary["live"], metrics.get("hole_share"), summary["time_ms"]["total"]
    age, pose_age, time = live["age_ms"], live["pose_age_ms"], TIME_FIGURES[-1]
    return [
        Tile("Frame age at display", "ms", _MS.text(age["median"]), _tail(_MS, age, "from drawing to showing")),
        Tile(
            "Pose age at hand-over",
            "ms",
            _SHORT_MS.text(pose_age["median"]),
            _tail(_SHORT_MS, pose_age, "from reading the head to submitting the picture"),
        ),
        miss_tile(summary["miss"]),
        Tile("Time per eye", "ms", time.text(total["median"]), _tail(time, total, "all stages")),
        Tile(
            holes.label,
            holes.figure.unit,
            holes.figure.text(summary["quality"][holes.name]["mean"]),
            holes.tile_note,
        ),
    ]


def _tail(figure: Figure, entry: Mapping[str, float | None], what: str) -> str:
    return what if entry["p95"] is None else f"{what}; p95 {figure.text(entry['p95'])} ms"


def _change(one: Mapping[str, Any]) -> tuple[str, str, str]:
    what = ", ".join(f"{name} {_value(before)} → {_value(after)}" for name, (before, after) in one["what"].items())
    return f"{one['time_s']:.2f} s", what, one["reason"]


def _value(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def _charts(summary: Summary, column: Column) -> list[Chart]:
    time_s, budget_ms, holes = column("time_s"), summary["live"]["budget_ms"], metrics.get("hole_share")
    limit = Series("a refresh of the display", time_s, np.full(len(time_s), budget_ms))
    both_eyes = holes.scale * np.concatenate([column("hole_share/0"), column("hole_share/1")])
    lines = (
        ("Frame age at display", [Series("", time_s, column("age_ms"))], "ms"),
        ("Pose age at hand-over", [Series("", time_s, column("pose_age_ms"))], "ms"),
        ("From picture to picture", [Series("from picture to picture", time_s, column("period_ms")), limit], "ms"),
        (
            f"{drawing_text(summary).capitalize()} and all passes of {eyes_text(summary)}",
            [Series("drawing and passes", time_s, column("busy_ms")), limit],
            "ms",
        ),
        (holes.chart, [Series("", np.concatenate([time_s, time_s]), both_eyes)], holes.chart_unit),
        ("Angular speed of the head", [Series("", time_s, column("angular_speed_deg_s"))], "deg/s"),
    )
    return [Chart(heading, time_series(series, unit)) for heading, series, unit in lines]
