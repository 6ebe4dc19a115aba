"""report.html of a replay and of a live run."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from ..metrics import LEAST_INSTANTS, PRIMARY, Figure, Input, Kept, excludes_zero, metrics, metrics_in_order
from . import page, run_texts
from .charts import Series, time_series, timeline_svg
from .files import ERROR_TOP, Panel, comparison_columns
from .page import texts
from .run_texts import Cell, Line, Summary, Table

if TYPE_CHECKING:
    from rich.table import Table as TerminalTable

Rows = Sequence[Mapping[str, Any]]

EYES = ("left eye", "right eye")
# (heading, column, unit)
_MOTION_CHARTS = (
    ("Age of the shown frame", "age_ms", "ms"),
    ("Angular speed of the head", "angular_speed_deg_s", "deg/s"),
    ("Linear speed of the head", "linear_speed_m_s", "m/s"),
)
_SCALE = Markup(f"<span>0 no visible error</span><i></i><span>FLIP {ERROR_TOP:g} and more</span>")


@attrs.frozen(eq=False)
class WorstFrame:
    """One picture of the strip of worst frames."""

    time_s: float
    eye: int  # 0 left, 1 right
    columns: Sequence[Sequence[Panel]]  # as comparison_columns makes them
    values: Mapping[str, float | None]  # by metric


def columns_of(kept: Kept) -> list[list[Panel]]:
    """Return the labelled panels of a kept picture in columns."""
    assert kept.result.error_map is not None
    job, own = kept.job, ("warped", kept.job.now.shown, kept.result.error_map)
    return comparison_columns(job.rendered_picture, job.now.truth, [own, *job.beside])


def render_report(
    summary: Summary,
    baselines: Sequence[Summary] = (),
    *,
    rows: Rows,
    baselines_rows: Sequence[Rows] = (),
    worst: Sequence[WorstFrame] = (),
    command: str,
    notes: Sequence[str] = (),
    gate: page.Section | None = None,
) -> str:
    """Return the text of report.html; the same arguments give the same text.

    summary, baselines: as summary.json. rows, baselines_rows: as frames.csv's, None for absent
    values. command: as the user typed it. notes: the run's, one sentence each. gate: its verdict.
    """
    names, notes_of = _column_names(summary, *baselines), texts("replay")["notes"]
    truth = "what a renderer without any delay would have shown at that instant"
    truth = truth if "recorded" not in summary else "the recorded frame nearest to that instant"
    axes = Markup(" in axes <b>{}</b>").format(summary["trace_axes"]) if summary.get("trace_axes") else ""
    count, pictures = summary.get("measured", {}).get(PRIMARY), summary.get("eyes", 2) * summary["frames"]
    figures = [(m.label, m.figure, "quality", "mean", m.tile_note) for m in metrics_in_order() if m.tile_note]
    figures.append(("Time per eye", run_texts.TIME_FIGURES[-1], "time_ms", "median", "all stages, median per eye"))
    tiles, others = [], [*zip(names[1:], baselines, strict=True)]
    for label, figure, table, main, note in figures:
        mine, *theirs = (figure.text(one[table][figure.name][main]) for one in (summary, *baselines))
        beside = "; ".join(f"{name}: {text}" for name, text in zip(names[1:], theirs, strict=True))
        tiles.append(page.Tile(label, figure.unit, mine, note, beside))
    eyes, shown = EYES if summary.get("eyes", 2) == 2 else ("camera",), []
    for frame in worst:
        when = f"{frame.time_s:.2f} s, {eyes[frame.eye]}"
        values = [
            Markup("<span>{} <b>{}</b>{}</span> ").format(f.label, f.text(value), f" {f.unit}" if f.unit else "")
            for f in run_texts.QUALITY_FIGURES
            if (value := frame.values.get(f.name)) is not None
        ]
        stacks = [
            page.Group("stack", [page.Picture.of(label, one, f"{label} at {when}") for label, one in column])
            for column in frame.columns
        ]
        panels = page.Group("panels slides", stacks)
        shown.append(
            page.Article([page.Heading(when), page.Text(Markup("").join(values), "figures"), panels], style="worst")
        )
    about = notes_of["figures"].format(
        rising=run_texts.listed([metric.label for metric in metrics_in_order() if metric.higher_is_better]),
        sure=_how_sure(summary, mark="★" if baselines else None),
    ) + (notes_of["compared"] if baselines else "")
    about += "".join(f" {name} ran with fill {one['fill']} and lens {one['lens']}." for name, one in others)
    regions: Mapping[str, Any] = summary.get("regions") or {}
    is_parted, of_region = any(one["share"] for one in regions.values()), ("share", "psnr_db", PRIMARY)
    parts = (
        (part.replace("_", " "), *(run_texts.figure_of(key).text(one[key]) for key in of_region))
        for part, one in regions.items()
    )
    heads = [("", ""), *((run_texts.figure_of(key).label, run_texts.figure_of(key).unit) for key in of_region)]
    by_region = [Table.of("", heads, parts, label="Error by region"), page.Text(texts("bench")["notes"]["regions"])]
    about_charts = notes_of["charts"].format(eyes=run_texts.eyes_text(summary))
    charts = metric_charts(dict(zip(names, (rows, *baselines_rows), strict=True)))
    charts += [
        page.Chart.over_time(heading, time_series([Series.of("", rows, name)], unit))
        for heading, name, unit in _MOTION_CHARTS
    ]
    return page.Page(
        kind="replay",
        title=f"hmdwarp: {summary['warp']} at {summary['latency_ms']:g} ms, {summary['trace']}",
        heading=(summary["warp"], f"at {summary['latency_ms']:g} ms"),
        facts=[
            page.fact("head trace", summary["trace"], axes),
            *(page.fact(*pair) for pair in run_texts.source_facts(summary)),
            *(page.fact(name, summary[name]) for name in ("fill", "predict", "lens", "headset")),
            _size_fact(summary),
            f"{summary['frames']} frames" + ("" if count is None else f", {count} of {pictures} pictures measured"),
        ],
        command=command,
        sections=(
            gate,
            page.Section("", tiles, style="tiles", label="Main figures"),
            page.notes_section(notes),
            page.Section("Worst frames", shown and [page.Text(notes_of["worst"]), *shown, page.Text(_SCALE, "scale")]),
            page.Section("Figures", [comparison_table(summary, *baselines), page.Text(about)]),
            page.Section("Where the error lies", by_region if is_parted else []),
            _transit_section(summary, ("Holes, of all pixels", run_texts.filled_rows(summary)),
                            ("On the client, uncompressed", run_texts.model_rows(summary))),
            page.Section("Over time", [page.Group("charts", charts), page.Text(about_charts)]),
            page.reading_section(
                "replay", *((m.label, m.explanation) for m in metrics_in_order() if m.explanation), truth=truth
            ),
        ),
        made_with=made_with(summary),
    ).html()  # fmt: skip


def made_with(summary: Summary) -> list[tuple[str, str]]:
    pairs = page.machine_pairs(summary["hmdwarp"], summary["machine"], summary["clock"])
    return [*pairs, ("Effects", ", ".join(summary["effects"]) or "none")]


def _size_fact(summary: Summary) -> Markup:
    """Return the size of an eye's picture, and what was rendered where that is more."""
    size = Markup("{}×{} per eye").format(*summary["size"])
    rendered = summary.get("rendered")
    if not rendered or rendered["size"] == summary["size"]:
        return size
    across, down = rendered["fov_deg"]
    more = Markup(", rendered <b>{}</b> ({:.2f} times the pixels, {:.1f} × {:.1f} degrees)")
    return size + more.format("×".join(map(str, rendered["size"])), rendered["pixels"], across, down)


def _transit_section(summary: Summary, *more: tuple[str, Sequence[tuple[str, str]]]) -> page.Section | None:
    """Return the section on the frames in transit. more: heading and pairs of further tables."""
    response = run_texts.response_rows(summary)
    if not response:
        return None
    tables: dict[str, Sequence[tuple[str, str]]] = {"Response time, means over the refreshes": response}
    tables |= {"Frames": run_texts.frame_rows(summary), "Size": run_texts.coding_rows(summary), **dict(more)}
    pairs = [Table.of(heading, (), rows, is_pairs=True) for heading, rows in tables.items() if rows]
    frames = (summary.get("link") or {}).get("timeline") or ()
    ways = {tuple(round(part, 3) for part in frame["parts"].values()) for frame in frames}
    timeline = timeline_svg(frames) if len(ways) > 1 else ""
    title = "The last frames, part by part"
    drawn = [page.Heading(title), page.Chart.of("", timeline, title, "wide plain")] if timeline else []
    return page.Section(
        "Frames in transit", [page.Group("pairs", pairs), *drawn, page.Text(texts("replay")["notes"]["transit"])]
    )


def metric_charts(runs: Mapping[str, Rows]) -> list[page.Chart]:
    """Return the charts over time of the metrics, the primary one first. runs: by name."""
    charts = []
    for metric in sorted((metric for metric in metrics_in_order() if metric.chart), key=lambda m: m.name != PRIMARY):
        series = [Series.of(name, rows, metric.name, metric.scale) for name, rows in runs.items()]
        svg = time_series(series, metric.chart_unit, from_zero=metric.chart_from_zero, points=True)
        charts.append(page.Chart.over_time(metric.chart, svg))
    return charts


def comparison_table(summary: Summary, *baselines: Summary) -> Table:
    """Return quality, then time per eye, of the run and of each baseline, each beside its bad tail.

    The run is marked if it is better than each baseline, a baseline if it is better than the run
    and no other has a better mean: if the difference over the instants holds. Time and holes are no
    contest: a warp that does nothing is quick and leaves nothing empty.
    """
    lines = []
    for figure in (*run_texts.QUALITY_FIGURES, *run_texts.TIME_FIGURES):
        is_time, best = figure in run_texts.TIME_FIGURES, None
        if baselines and not is_time and metrics.get(figure.name).is_contest:
            sign = 1 if figure.higher_is_better else -1
            found = [baseline.get("difference", {}).get(figure.name) for baseline in baselines]
            # How much better the run is than each, 0 where that is not sure.
            gains = [sign * one["mean"] if one and excludes_zero(one["interval"]) else 0.0 for one in found]
            best = (0 if min(gains) > 0 else 1 + gains.index(min(gains))) if min(gains) else None
        label = f"Time, {figure.label.lower()}" if is_time else figure.label
        cells = [Cell(f"{label} [{figure.unit}]" if figure.unit else label)]
        for number, one in enumerate((summary, *baselines)):
            entry = one["time_ms" if is_time else "quality"][figure.name]
            mean, interval = figure.text(entry["median" if is_time else "mean"]), entry.get("interval")
            if interval is not None:
                low, high = (f"{end * figure.scale:.2g}" for end in interval)
                is_cut = not math.isclose(interval[1] - entry["mean"], entry["mean"] - interval[0], abs_tol=1e-12)
                mean += f" ({low} to {high})" if is_cut else f" ±{figure.text((interval[1] - interval[0]) / 2)}"
            cells += [Cell(mean, "best" if number == best else ""), Cell(figure.text(entry["p95"]), "tail")]
        groups = {run_texts.QUALITY_FIGURES[0]: "Picture, mean", run_texts.TIME_FIGURES[0]: "Time per eye, median"}
        lines.append(Line(tuple(cells), group=groups.get(figure, "")))
    heads = [("", ""), *(pair for name in _column_names(summary, *baselines) for pair in ((name, ""), ("p95", "")))]
    return Table("", heads, lines, label="Figures")


def _how_sure(summary: Summary, *, mark: str | None) -> str:
    """Return what the intervals are and what a mark (None for none) says, or why none are."""
    if all(entry.get("interval") is None for entry in summary["quality"].values()):
        return f"No intervals{f' and no {mark}' if mark else ''}: they need {LEAST_INSTANTS} measured refreshes"
    best = f"; {mark}: the best of the line, by the 95 % interval of the difference" if mark else ""
    return f"± or (low to high): 95 % interval of the mean{best}"


def _column_names(summary: Summary, *baselines: Summary) -> list[str]:
    """Return the heads of the comparison's columns: the options that differ, at least the warp."""
    for keys in (("warp",), ("warp", "fill"), ("warp", "fill", "lens")):
        names = [", ".join(s[key] for key in keys) for s in (summary, *baselines)]
        if len(set(names)) == len(names):
            return names
    return ["this run", *(f"baseline {number}" for number in range(1, len(names)))]


def summary_table(summary: Summary, *baselines: Summary) -> TerminalTable:
    """Return the table that ends a run: means (medians for times) with the bad tail next to them.

    The best column of each quality line is bold and starred, so that it reads without colour too.
    Only the first baseline has its tail next to it, where a terminal has room for no more.
    """
    source = "scene" if "recorded" not in summary else "recorded frames"
    of_what = f"{source} {summary['scene']}, {summary['frames']} frames"
    title = f"{summary['trace']} at {summary['latency_ms']:g} ms, {of_what}"
    clock = "GPU timers" if summary["clock"] == "gpu" else "wall clock"
    lines = ["mean over measured pictures; p95: 5 % are worse", f"times: median per eye, {clock}"]
    lines[1] += "".join("; baseline {warp}: fill {fill}, lens {lens}".format(**one) for one in baselines)
    caption = "\n".join([*lines, _how_sure(summary, mark="*" if baselines else None)])
    table = comparison_table(summary, *baselines)
    tails = range(2, 3 if len(baselines) > 1 else 5)
    shown = [at for at in range(len(table.heads)) if at == 0 or at % 2 or at in tails]
    return table.terminal(shown, title=title, caption=caption)


def summary_html(summary: Summary, *baselines: Summary) -> str:
    """Return that table as HTML, for a notebook."""
    table = comparison_table(summary, *baselines)
    return table.html([0, *range(1, len(table.heads), 2)])


Column = Callable[[str], NDArray[np.float64]]

_MS = Figure("", "", "ms", 1)
_SHORT_MS = Figure("", "", "ms", 2)
_ABOUT = {"trace_axes": "axes of the trace"}


def render_live_report(summary: Summary, column: Column, *, command: str) -> str:
    """Return the text of report.html.

    summary: as summary.json, with `live`. column(name): the numbers behind it over time, NaN where
    there is none: time_s, age_ms, pose_age_ms, period_ms, busy_ms, angular_speed_deg_s,
    linear_speed_m_s, hole_share/0, hole_share/1. command: as the user typed it.
    """
    live = summary["live"]
    changes = []
    for change in live["changes"]:
        what = ", ".join(f"{name} {_value(old)} → {_value(new)}" for name, (old, new) in change["what"].items())
        changes.append((f"{change['time_s']:.2f} s", f"{what} ({change['reason']})"))
    recorded = Markup(" · recorded to <b>{}</b>").format(live["record"]) if live["record"] else ""
    pictures = Markup("{} pictures in {:.1f} s{}").format(summary["frames"], live["seconds"], recorded)
    about = [(_ABOUT.get(name, name.replace("_", " ")), text) for name, text in live["about"].items() if text]
    pairs = [("source", live["source"]), *about, *run_texts.source_facts(summary)]
    pairs += [(name, summary[name]) for name in ("fill", "lens")]
    over_time = [page.Group("charts", _live_charts(summary, column)), page.Text(texts("live")["notes"]["charts"])]
    errors = run_texts.listed([metric.short_label for metric in metrics_in_order() if Input.TRUTH in metric.needs])
    notices = "; ".join(f"{text} ({count}×)" for text, count in live["notices"].items())
    return page.Page(
        kind="live",
        title=f"hmdwarp live: {summary['warp']} at {summary['latency_ms']:g} ms, {live['source']}",
        heading=(summary["warp"], f"at {summary['latency_ms']:g} ms"),
        facts=[*(page.fact(*pair) for pair in pairs), _size_fact(summary), pictures],
        command=command,
        sections=(
            page.Section("", _live_tiles(summary), style="tiles", label="Main figures"),
            page.notes_section(summary["notes"]),
            _refresh(summary),
            _transit_section(summary),
            page.Section("Changes", [page.Terms(changes, "changes")] if changes else []),
            page.Section("Over time", over_time),
            page.reading_section(
                "live",
                *([("Shown over the picture", notices)] if notices else []),
                errors=errors,
                waiting=str(live["waiting"]),
                unseen=str(live["unseen"]),
            ),  # fmt: skip
        ),
        made_with=made_with(summary),
    ).html()


def _live_tiles(summary: Summary) -> list[page.Tile]:
    def tile(label: str, figure: Figure, entry: Mapping[str, float | None], note: str) -> page.Tile:
        tail = "" if entry["p95"] is None else f"; p95 {figure.text(entry['p95'])} ms"
        return page.Tile(label, "ms", figure.text(entry["median"]), note + tail)

    live, holes, total = summary["live"], metrics.get("hole_share"), summary["time_ms"]["total"]
    share, time = holes.figure.text(summary["quality"][holes.name]["mean"]), run_texts.TIME_FIGURES[-1]
    handed, waits = "from reading the head to submitting the picture", run_texts.waited_text(live)
    share_missed, longest = (summary["miss"][key] for key in ("stale_share", "longest_stale"))
    miss = page.Tile("Missed refreshes", "%", f"{100 * share_missed:.1f}", f"at most {longest} in a row")
    return [
        tile("Frame age at display", _MS, live["age_ms"], "from drawing to showing"),
        tile("Pose age at frame submission", _SHORT_MS, live["pose_age_ms"], handed),
        page.Tile("Missed refreshes", "", "–", waits) if waits else miss,
        tile("Time per eye", time, total, "all stages"),
        page.Tile(holes.label, holes.figure.unit, share, holes.tile_note),
    ]


def live_lines(summary: Summary, folder: Path | None) -> list[str]:
    """Return the lines that end a live run. summary: empty if no picture was shown."""
    if not summary:
        return ["no picture was shown"]
    live = summary["live"]
    rate = f", {(live['refreshes'] - 1) / live['seconds']:.1f} a second" if live["seconds"] > 0 else ""
    lines = [("Shown", f"{run_texts.counted(live['refreshes'], 'picture')} in {live['seconds']:.1f} s{rate}")]
    for tile in _live_tiles(summary):
        if tile.text != "–" or not tile.unit:
            lines.append((tile.label, f"{f'{tile.text} {tile.unit}'.strip()}, {tile.note}"))
    lines += [("note", note) for note in summary["notes"]]
    lines += [] if folder is None else [("report", str(folder / "report.html"))]
    return [f"{label + ':':<30}{text}" for label, text in lines]


def _refresh(summary: Summary) -> page.Section:
    live = summary["live"]
    lines, shares = [], {name: (one["median"] or 0.0) / live["budget_ms"] for name, one in live["refresh_ms"].items()}
    for name, share in shares.items():
        part = f"{run_texts.drawing_text(summary)} by the server" if name == "render" else name
        median, tail = (_SHORT_MS.text(live["refresh_ms"][name][key]) for key in ("median", "p95"))
        bar = Markup('<i style="width: {:.1f}%"></i>').format(100 * share / max(1.0, *shares.values()))
        cells = (Cell(part), Cell(median), Cell(tail, "tail"), Cell(f"{share:.0%}"), Cell(bar, "meter"))
        lines.append(Line(cells))
    budget = f"{live['budget_ms']:.2f}"
    heads = [(head, "") for head in ("all eyes together", "median, ms", "p95", f"of {budget} ms", "")]
    note = texts("live")["notes"]["budget"].format(
        rate=f"{round(summary['rate_hz'], 2):g}", budget=budget, over=f"{live['over'] / max(1, live['timed']):.1%}"
    )
    return page.Section("Time per refresh", [Table("", heads, lines, label="Time per refresh"), page.Text(note)])


def _value(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def _live_charts(summary: Summary, column: Column) -> list[page.Chart]:
    time_s, budget_ms, holes = column("time_s"), summary["live"]["budget_ms"], metrics.get("hole_share")
    limit = Series("a refresh of the display", time_s, np.full(len(time_s), budget_ms))
    both_eyes = holes.scale * np.concatenate([column("hole_share/0"), column("hole_share/1")])
    busy = f"{run_texts.drawing_text(summary).capitalize()} and all passes of {run_texts.eyes_text(summary)}"

    def line(name: str, label: str = "") -> Series:
        return Series(label, time_s, column(name))

    charts = (
        ("Frame age at display", [line("age_ms")], "ms"),
        ("Pose age at frame submission", [line("pose_age_ms")], "ms"),
        ("Frame interval", [line("period_ms", "frame interval"), limit], "ms"),
        (busy, [line("busy_ms", "drawing and passes"), limit], "ms"),
        (holes.chart, [Series("", np.concatenate([time_s, time_s]), both_eyes)], holes.chart_unit),
        ("Angular speed of the head", [line("angular_speed_deg_s")], "deg/s"),
    )
    return [page.Chart.over_time(heading, time_series(series, unit)) for heading, series, unit in charts]
