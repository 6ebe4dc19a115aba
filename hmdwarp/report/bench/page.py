"""bench.html: one page that holds its tables and charts and loads nothing from the network."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from ...metrics import REGIONS, Figure, metrics, metrics_in_order
from ..parts import CLOCK_NAMES, Cell, Line, PageChart, PageTable, Tile, environment
from ..style import css_variables, markers_of
from ..tables import axes_of_traces
from ..words import counted, listed, plain
from .bars import region_parts, regions_chart, row_name, traffic, traffic_chart
from .charts import pareto_chart, pareto_text
from .displacement import axes_of, axis_heading, curves, displacement_chart, displacement_text, is_turn
from .rows import COLUMNS, Case, Row, cases, column, common, measure_label
from .tables import choice_terms, decision, marked_how

MEASURES = ("flip", "psnr_db")
_REFERENCE = ("forward", "interpolate")  # the pipeline of the thesis that this project began with
_KEYS_OF_A_CHOICE = {"budget_ms", "warp", "fill", "settings", "total_ms", "flip", "psnr_db", "sizes", "cases", "next"}


def render_bench_page(data: Mapping[str, Any]) -> str:
    """Return the text of the page from the content of bench.json.

    The same content gives the same text.

    Sections without data (no grid, no fused rows, no budget) are left out. All text from the data
    is escaped.
    """
    rows: list[Row] = list(data["rows"])
    groups = cases(rows)
    grid = list(data.get("grid") or ())
    return environment().get_template("bench.html").render(
        title=_title(rows, groups),
        facts=_facts(rows, groups),
        command=data.get("command") or "",
        tiles=_tiles(data, rows),
        notes=_notes(data, rows),
        choice=_choice(data.get("choice")),
        winners=_winners(groups),
        decisions=[(group.label, _decision(group)) for group in groups],
        sure=marked_how(rows, mark="★ and bold"),
        fronts=_fronts(groups, rows),
        displacement=[_displacement(grid, axis) for axis in axes_of(grid)],
        displacement_table=_displacement_table(grid),
        displacement_at=_taken_at(data.get("grid_at")),
        regions=_regions(groups),
        fused=_fused(data.get("fused") or ()),
        fused_at=_taken_at(data.get("fused_at")),
        traffic=_traffic(rows),
        measures=[(name, measure_label(name).partition(",")[0]) for name in MEASURES],
        metrics=metrics_in_order(),
        rated=any("jod" in row for row in rows),
        clock=_clock(data),
        clock_note=(data.get("clocks") or {}).get("note") or "",
        machine=data.get("machine") or {},
        version=data.get("hmdwarp") or "–",
        light=css_variables(dark=False),
        dark=css_variables(dark=True),
    )  # fmt: skip


def _clock(data: Mapping[str, Any]) -> str:
    return CLOCK_NAMES.get(data.get("clock", ""), str(data.get("clock")))


def _unique(rows: Iterable[Row], key: str) -> list[Any]:
    return list(dict.fromkeys(row[key] for row in rows))


def _title(rows: Sequence[Row], groups: Sequence[Case]) -> tuple[str, str]:
    warps, fills = len(_unique(rows, "warp")), len(_unique(rows, "fill"))
    methods = counted(warps, "warp") + (f" × {counted(fills, 'fill')}" if fills > 1 else "")
    return methods, f"in {counted(len(groups), 'case')}"


def _facts(rows: Sequence[Row], groups: Sequence[Case]) -> list[tuple[str, str]]:
    facts = [
        ("recordings", listed([str(trace) for trace in _unique(rows, "trace")])),
        *((f"axes of {trace}", axes) for trace, axes in axes_of_traces(rows).items()),
        ("latencies", listed([f"{latency:g} ms" for latency in _unique(rows, "latency_ms")])),
        ("fills", listed(_unique(rows, "fill"))),
    ]
    return [(label, text) for label, text in facts if text] + [("", text) for text in common(rows)]


def _tiles(data: Mapping[str, Any], rows: Sequence[Row]) -> list[Tile]:
    clocks = data.get("clocks") or {}
    gpu, wall = clocks.get("gpu_ms"), clocks.get("wall_ms")
    both = " / ".join("–" if value is None else f"{value:.3g}" for value in (gpu, wall))
    seconds, clock = data.get("seconds"), data.get("clock", "")
    ran = f"run in {seconds / 60:.1f} min" if seconds else "warp, fill, recording, latency"
    tiles = [
        Tile("Combinations", "", str(len(rows)), ran),
        Tile("Clock", "", {"gpu": "GPU", "wall": "wall"}.get(clock, "?"), CLOCK_NAMES.get(clock, "")),
        Tile("One pass, two clocks", "ms", both, "GPU timer / wall clock; where they agree, the timer is real"),
    ]
    if data.get("copy_gb_s"):
        note = "measured on this device; the bounds below follow from it"
        tiles.append(Tile("Copy bandwidth", "GB/s", f"{data['copy_gb_s']:.1f}", note))
    return tiles


def _notes(data: Mapping[str, Any], rows: Sequence[Row]) -> list[str]:
    """Return each note once, the bench's first; a row's note with its rows, or their number."""
    rows_of: dict[str, list[str]] = {str(note): [] for note in data.get("notes") or ()}
    for row in rows:
        for note in row.get("notes") or ():
            rows_of.setdefault(str(note), []).append(f"{row_name(row)}, {row['trace']}, {row['latency_ms']:g} ms")
    where = {
        note: "; ".join(names) if len(names) <= 3 else f"{len(names)} combinations" for note, names in rows_of.items()
    }
    return [f"{note} ({names})" if names else note for note, names in where.items()]


def _choice(choice: Mapping[str, Any] | None) -> dict[str, Any] | None:
    if not choice:
        return None
    settings = choice.get("settings")
    settings = dict(settings) if isinstance(settings, Mapping) else {"settings": settings} if settings else {}
    settings |= {key: value for key, value in choice.items() if key not in _KEYS_OF_A_CHOICE and value is not None}
    step = choice.get("next")
    return {
        "budget": f"{choice['budget_ms']:g}",
        "name": f"{choice['warp']} + {choice['fill']}",
        "settings": [f"{name} {value}" for name, value in settings.items()],
        "time": f"{choice['total_ms']:.2f}",
        "figures": _figures(choice),
        "terms": choice_terms(choice),
        "next": step and {
            "name": f"{step['warp']} + {step['fill']}",
            "time": f"{step['total_ms']:.2f}",
            "figures": _figures(step),
            "gain": _gain(choice, step),
        },
    }  # fmt: skip


def _figures(entry: Mapping[str, Any]) -> str:
    flip, psnr = (metrics.get(name).short_figure.text(entry.get(name)) for name in ("flip", "psnr_db"))
    return f"FLIP {flip}, PSNR {psnr} dB"


def _gain(choice: Mapping[str, Any], step: Mapping[str, Any]) -> str:
    parts = []
    if choice.get("flip") and step.get("flip") is not None:
        parts.append(f"{100 * (1 - step['flip'] / choice['flip']):+.0f} % of the FLIP error removed".replace("+", ""))
    if choice.get("psnr_db") is not None and step.get("psnr_db") is not None:
        parts.append(f"{step['psnr_db'] - choice['psnr_db']:+.2f} dB")
    parts.append(f"{step['total_ms'] - choice['total_ms']:+.2f} ms")
    return ", ".join(parts)


def _decision(case: Case) -> PageTable:
    columns = [column(name) for name in decision(case.rows)]
    best = {id(row) for row in case.held()}
    lines = [Line(tuple(Cell(c.text(row), c.is_number) for c in columns), id(row) in best) for row in case.ordered()]
    heads = tuple((c.figure.label, c.figure.unit) for c in columns)
    return PageTable(f"{case.label}, least FLIP first", heads, tuple(lines), has_marks=True)


def _winners(groups: Sequence[Case]) -> PageTable:
    """Return each case's most accurate row and its most accurate within the thesis's time."""
    lines: list[list[str]] = []
    has_limit = False
    for group in groups:
        measured = [
            row for row in group.ordered() if not row.get("lacks") and row["quality"]["flip"]["mean"] is not None
        ]
        limit = next((_total(row) for row in measured if (row["warp"], row["fill"]) == _REFERENCE), None)
        within = [
            row for row in measured if limit is not None and (total := _total(row)) is not None and total <= limit
        ]
        has_limit |= limit is not None
        lines.append([group.label, *_first(measured), *_first(within), plain(limit)])
    heads = [("case", ""), ("most accurate", ""), ("time", "ms"), ("FLIP", "")]
    heads += [("best no slower than forward + interpolate", ""), ("time", "ms"), ("FLIP", ""), ("that takes", "ms")]
    shown = len(heads) if has_limit else 4
    cells = [tuple(Cell(text, n not in (0, 1, 4)) for n, text in enumerate(texts[:shown])) for texts in lines]
    return PageTable("The most accurate of each case", tuple(heads[:shown]), tuple(map(Line, cells)))


def _total(row: Row) -> float | None:
    return row["time_ms"]["total"]["median"]


def _first(rows: Sequence[Row]) -> list[str]:
    if not rows:
        return ["–", "–", "–"]
    return [row_name(rows[0]), COLUMNS["total_ms"].text(rows[0]), COLUMNS["flip"].text(rows[0])]


def _fronts(groups: Sequence[Case], rows: Sequence[Row]) -> list[PageChart]:
    markers = markers_of(row["fill"] for row in rows)

    def versions(group: Case) -> tuple[tuple[str, str, str], ...]:
        return tuple(
            (measure, pareto_chart(group, measure, markers=markers), pareto_text(group, measure))
            for measure in MEASURES
        )

    return [PageChart(group.label, versions(group)) for group in groups]


def _displacement(grid: Sequence[Mapping[str, Any]], axis: str) -> PageChart:
    versions = tuple((m, displacement_chart(grid, axis, m), displacement_text(grid, axis, m)) for m in MEASURES)
    return PageChart(axis_heading(axis), versions)


def _displacement_table(grid: Sequence[Mapping[str, Any]]) -> PageTable | None:
    """Return FLIP at the worse end of each axis, warp by warp."""
    axes = axes_of(grid)
    lines_of = {axis: curves(grid, axis) for axis in axes}
    warps = list(dict.fromkeys(row["warp"] for row in grid))
    if not warps:
        return None

    def worse_end(axis: str, warp: str) -> str:
        points = lines_of[axis].get(warp)
        return "–" if points is None or not len(points) else f"{max(points[0, 1], points[-1, 1]):.3f}"

    def reach(axis: str) -> str:
        return f"±{max(abs(row['offset']) for row in grid if row['axis'] == axis):g} {'°' if is_turn(axis) else 'm'}"

    heads = [("warp", ""), *((axis, reach(axis)) for axis in axes)]
    lines = [[warp, *(worse_end(axis, warp) for axis in axes)] for warp in warps]
    return PageTable.of("FLIP at the worse end of each axis", heads, lines)


def _regions(groups: Sequence[Case]) -> list[PageChart]:
    charts = []
    for group in groups:
        if any(region_parts(row) for row in group.rows):
            words = f"Error by region, {group.label}: see the table below"
            charts.append(PageChart.of(group.label, regions_chart(group), words, _regions_table(group)))
    return charts


def _regions_table(case: Case) -> PageTable:
    names = [f"{region}_{figure}" for region in REGIONS for figure in ("share", "flip", "psnr_db")]
    columns = [column("warp"), column("fill"), *(column(name) for name in names)]
    heads = [(c.figure.label, c.figure.unit) for c in columns]
    lines = [[c.text(row) for c in columns] for row in case.ordered() if region_parts(row)]
    return PageTable.of(f"Error by region, {case.label}", heads, lines, words=2)


def _fused(rows: Iterable[Mapping[str, Any]]) -> PageTable | None:
    figures = [
        *(metrics.get(name).short_figure for name in ("psnr_db", "flip")),
        Figure("sharpness", "sharpness", "", 2),
    ]
    forms = ("fused", "separate")
    heads = [("warp", ""), ("fused", "ms"), ("separate", "ms"), ("speed-up", "×")]
    heads += [(f"{figure.label} {form}", figure.unit) for figure in figures for form in forms]
    lines = [
        [
            str(row["warp"]),
            *(plain(row.get(name)) for name in ("fused_ms", "separate_ms", "speedup")),
            *(figure.text((row.get(figure.name) or {}).get(form)) for figure in figures for form in forms),
        ]
        for row in rows
    ]
    return PageTable.of("Warp and lens in one resample, against two", heads, lines) if lines else None


def _taken_at(at: Mapping[str, Any] | None) -> str:
    """Return where a section was measured once: 'scene room, 400x400, left eye'."""
    if not at:
        return ""
    parts = [f"scene {at['scene']}"]
    if "trace" in at:
        parts.append(f"{at['trace']}, {at['latency_ms']:g} ms")
    parts.append("x".join(map(str, at["size"])))
    return ", ".join([*parts, *([f"lens {at['lens']}"] if "lens" in at else []), f"{at['eye']} eye"])


def _traffic(rows: Sequence[Row]) -> PageChart | None:
    passes = traffic(rows)
    if not passes:
        return None
    heads = [("pass", ""), ("size", ""), ("moves", "MB"), ("bound", "ms"), ("takes", "ms"), ("times the bound", "")]
    lines = [
        [p.label, p.size, *map(plain, (p.bytes / 1e6, p.bound_ms, p.median_ms)), plain(p.times_bound, 1)]
        for p in passes
    ]
    words = "Time of each pass and its bound: " + ", ".join(f"{p.label} {p.times_bound:.1f} times" for p in passes)
    table = PageTable.of("Traffic and time of each pass", heads, lines, words=2)
    return PageChart.of("", traffic_chart(passes), words, table)
