"""report.html of a live run: as a replay's, without a truth to compare with, and with what only a live run has."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .charts import Series, time_series
from .live_told import budget_rows, missed_share
from .page import CLOCK_NAMES, Chart, Tile, environment
from .tables import QUALITY_FIGURES, TIME_FIGURES, Figure, Summary
from .way import coding_rows, frame_rows, response_rows

Column = Callable[[str], NDArray[np.float64]]

_MS = Figure("", "", "ms", 1)
_SHORT_MS = Figure("", "", "ms", 2)


def render_live_report(summary: Summary, column: Column, *, command: str) -> str:
    """The text of report.html. summary: as summary.json, with `live`; column(name): the numbers behind it over time, NaN where there is
    none: time_s, age_ms, pose_age_ms, period_ms, busy_ms, angular_speed_deg_s, linear_speed_m_s, hole_share/0, hole_share/1.
    command: what the user typed."""
    live = summary["live"]
    return (
        environment()
        .get_template("live.html")
        .render(
            summary=summary,
            live=live,
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
            response=response_rows(summary),
            frames=frame_rows(summary),
            coding=coding_rows(summary),
            clock=CLOCK_NAMES[summary["clock"]],
        )
    )


def _tiles(summary: Summary) -> list[Tile]:
    live, holes = summary["live"], next(figure for figure in QUALITY_FIGURES if figure.name == "hole_share")
    missed = Tile(
        "Missed refreshes",
        "",
        str(live["missed"]),
        f"{missed_share(live):.1%} of {live['missed'] + live['refreshes']}",
        None,
    )
    return [
        Tile(
            "Age of the frame",
            "ms",
            _MS.text(live["age_ms"]["median"]),
            _tail(_MS, live["age_ms"], "from drawing to showing"),
            None,
        ),
        Tile(
            "Age of the pose",
            "ms",
            _SHORT_MS.text(live["pose_age_ms"]["median"]),
            _tail(_SHORT_MS, live["pose_age_ms"], "from reading the head to handing the picture over"),
            None,
        ),
        missed,
        Tile(
            "Time per eye",
            "ms",
            TIME_FIGURES[-1].text(summary["time_ms"]["total"]["median"]),
            _tail(TIME_FIGURES[-1], summary["time_ms"]["total"], "all stages"),
            None,
        ),
        Tile(
            holes.label,
            holes.unit,
            holes.text(summary["quality"]["hole_share"]["mean"]),
            "empty after the warp, before the fill",
            None,
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
    time_s, budget_ms = column("time_s"), summary["live"]["budget_ms"]
    limit = Series("a refresh of the display", time_s, np.full(len(time_s), budget_ms))
    holes = np.concatenate([column("hole_share/0"), column("hole_share/1")])
    single = (
        ("Age of the frame", Series("", time_s, column("age_ms")), "ms"),
        ("Age of the pose at submission", Series("", time_s, column("pose_age_ms")), "ms"),
    )
    against = (
        ("From picture to picture", Series("from picture to picture", time_s, column("period_ms"))),
        ("Drawing and all passes of both eyes", Series("drawing and passes", time_s, column("busy_ms"))),
    )
    rest = (
        ("Holes before the fill", Series("", np.concatenate([time_s, time_s]), 100 * holes), "% of pixels"),
        ("How fast the head turns", Series("", time_s, column("angular_speed_deg_s")), "deg/s"),
    )
    charts = [Chart(heading, time_series([series], unit)) for heading, series, unit in single]
    charts += [Chart(heading, time_series([series, limit], "ms")) for heading, series in against]
    return charts + [Chart(heading, time_series([series], unit)) for heading, series, unit in rest]
