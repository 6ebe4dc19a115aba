"""report.html of a live run: as a replay's, without a truth, with figures of its own."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from ..metrics import Figure, Input, metrics, metrics_in_order
from .charts import Series, time_series
from .page import Chart, Group, Page, Section, Terms, Text, Tile, fact, notes_section, reading_section, texts
from .replay_page import made_with, size_fact, transit_section
from .run_texts import (
    TIME_FIGURES,
    Cell,
    Line,
    Summary,
    Table,
    budget_rows,
    drawing_text,
    eyes_text,
    listed,
    miss_texts,
    source_facts,
    waited_text,
)

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
    changes = [
        (f"{change['time_s']:.2f} s", f"{_changed(change['what'])} ({change['reason']})") for change in live["changes"]
    ]
    charts = [Group("charts", _charts(summary, column)), Text(texts("live")["notes"]["charts"])]
    collector = live["garbage_collector"]
    when = "between the pictures" if collector["between"] else "at any time"
    collected = f"{sum(collector['collections'])} collections, {collector['total_ms']:.1f} ms in all"
    notices = "; ".join(f"{text} ({count}×)" for text, count in live["notices"].items())
    return Page(
        kind="live",
        title=f"hmdwarp live: {summary['warp']} at {summary['latency_ms']:g} ms, {live['source']}",
        heading=(summary["warp"], f"at {summary['latency_ms']:g} ms"),
        facts=_facts(summary),
        command=command,
        sections=(
            Section("", _tiles(summary), style="tiles", label="Main figures"),
            notes_section(summary["notes"]),
            _refresh(summary),
            transit_section(summary),
            Section("Changes", [Terms(changes, "changes")] if changes else []),
            Section("Over time", charts),
            reading_section(
                "live",
                *([("Shown over the picture", notices)] if notices else []),
                ("Garbage collector", f"{when}: {collected}, the longest {collector['longest_ms']:.2f} ms."),
                errors=listed([metric.short_label for metric in metrics_in_order() if Input.TRUTH in metric.needs]),
                waiting=str(live["waiting"]),
                unseen=str(live["unseen"]),
            ),
        ),
        made_with=made_with(summary),
    ).html()


_ABOUT = {"trace_axes": "axes of the trace"}


def _facts(summary: Summary) -> list[str]:
    live = summary["live"]
    recorded = Markup(" · recorded to <b>{}</b>").format(live["record"]) if live["record"] else ""
    pictures = Markup("{} pictures in {:.1f} s{}").format(summary["frames"], live["seconds"], recorded)
    about = [(_ABOUT.get(name, name.replace("_", " ")), text) for name, text in live["about"].items() if text]
    pairs = [("source", live["source"]), *about, *source_facts(summary)]
    pairs += [(name, summary[name]) for name in ("fill", "lens")]
    return [*(fact(*pair) for pair in pairs), size_fact(summary), pictures]


def _tiles(summary: Summary) -> list[Tile]:
    live, holes, total = summary["live"], metrics.get("hole_share"), summary["time_ms"]["total"]
    share, time = holes.figure.text(summary["quality"][holes.name]["mean"]), TIME_FIGURES[-1]
    handed, waits = "from reading the head to submitting the picture", waited_text(live)
    missed, longest, judder = miss_texts(summary["miss"])
    miss = Tile("Missed refreshes", "%", missed, f"at most {longest} in a row; judder {judder} deg RMS")
    return [
        _tile("Frame age at display", _MS, live["age_ms"], "from drawing to showing"),
        _tile("Pose age at hand-over", _SHORT_MS, live["pose_age_ms"], handed),
        Tile("Missed refreshes", "", "–", waits) if waits else miss,
        _tile("Time per eye", time, total, "all stages"),
        Tile(holes.label, holes.figure.unit, share, holes.tile_note),
    ]


def _tile(label: str, figure: Figure, entry: Mapping[str, float | None], note: str) -> Tile:
    tail = "" if entry["p95"] is None else f"; p95 {figure.text(entry['p95'])} ms"
    return Tile(label, "ms", figure.text(entry["median"]), note + tail)


def _refresh(summary: Summary) -> Section:
    """Return the parts of a refresh against its budget, with a bar for each."""
    live = summary["live"]
    lines, rows = [], budget_rows(summary)
    longest = max([1.0, *(share for *_, share in rows)])
    for part, median, tail, share in rows:
        bar = Markup('<i style="width: {:.1f}%"></i>').format(100 * share / longest)
        cells = (Cell(part), Cell(median), Cell(tail, "tail"), Cell(f"{share:.0%}"), Cell(bar, "meter"))
        lines.append(Line(cells))
    budget = f"{live['budget_ms']:.2f}"
    heads = [(head, "") for head in ("all eyes together", "median, ms", "p95", f"of {budget} ms", "")]
    note = texts("live")["notes"]["budget"].format(
        rate=f"{round(summary['rate_hz'], 2):g}", budget=budget, over=f"{live['over'] / max(1, live['timed']):.1%}"
    )
    return Section("Time per refresh", [Table("", heads, lines, label="Time per refresh"), Text(note)])


def _changed(what: Mapping[str, Any]) -> str:
    return ", ".join(f"{name} {_value(before)} → {_value(after)}" for name, (before, after) in what.items())


def _value(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def _charts(summary: Summary, column: Column) -> list[Chart]:
    time_s, budget_ms, holes = column("time_s"), summary["live"]["budget_ms"], metrics.get("hole_share")
    limit = Series("a refresh of the display", time_s, np.full(len(time_s), budget_ms))
    both_eyes = holes.scale * np.concatenate([column("hole_share/0"), column("hole_share/1")])
    busy = f"{drawing_text(summary).capitalize()} and all passes of {eyes_text(summary)}"

    def line(name: str, label: str = "") -> Series:
        return Series(label, time_s, column(name))

    charts = (
        ("Frame age at display", [line("age_ms")], "ms"),
        ("Pose age at hand-over", [line("pose_age_ms")], "ms"),
        ("From picture to picture", [line("period_ms", "from picture to picture"), limit], "ms"),
        (busy, [line("busy_ms", "drawing and passes"), limit], "ms"),
        (holes.chart, [Series("", np.concatenate([time_s, time_s]), both_eyes)], holes.chart_unit),
        ("Angular speed of the head", [line("angular_speed_deg_s")], "deg/s"),
    )
    return [Chart.over_time(heading, time_series(series, unit)) for heading, series, unit in charts]
