"""The bench's page: one file that holds its tables and charts and asks the network for nothing."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import attrs

from ..metrics import REGIONS
from .bench_bars import region_parts, regions_chart, row_name, traffic, traffic_chart
from .bench_cases import COLUMNS, Case, Row, cases, column, common, measure_label, sequence_text
from .bench_charts import pareto_chart, pareto_text
from .bench_displacement import axes_of, axis_heading, curves, displacement_chart, displacement_text, is_turn
from .bench_style import css_variables, markers_of
from .bench_tables import DECISION, choice_terms
from .page import environment

MEASURES = ("flip", "psnr_db")
_CLOCKS = {"gpu": "GPU timer queries", "wall": "wall clock around finished GPU work"}
_YARDSTICK = ("forward", "interpolate")  # the pipeline of the thesis that this project began with
_TOLD_OF_A_CHOICE = {"budget_ms", "warp", "fill", "settings", "total_ms", "flip", "psnr_db", "sizes", "cases", "next"}


@attrs.frozen
class Cell:
    """One cell of a table."""

    text: str
    is_number: bool = True


@attrs.frozen
class Line:
    """One line of a table; the first cell is its heading. `is_marked`: starred and bold."""

    cells: tuple[Cell, ...]
    is_marked: bool = False


@attrs.frozen
class PageTable:
    """A table of the page: heads are (label, unit)."""

    caption: str
    heads: tuple[tuple[str, str], ...]
    lines: tuple[Line, ...]
    has_marks: bool = False


@attrs.frozen
class PageChart:
    """A chart in one or more versions: (measure, svg, what it says in words)."""

    heading: str
    versions: tuple[tuple[str, str, str], ...]
    table: PageTable | None = None


def render_bench_page(data: Mapping[str, Any]) -> str:
    """The text of the page from the content of bench.json; the same content gives the same text.

    Sections without data (no grid, no fused rows, no budget) are left out. All text from the data is escaped.
    """
    rows: list[Row] = list(data["rows"])
    groups = cases(rows)
    grid = list(data.get("grid") or ())
    passes = traffic(rows)
    return (
        environment()
        .get_template("bench.html")
        .render(
            title=_title(rows, groups),
            facts=_facts(rows, groups),
            command=data.get("command") or "",
            tiles=_tiles(data, rows),
            notes=_notes(data, rows),
            choice=_choice(data.get("choice")),
            winners=_winners(groups),
            decisions=[(group.label, _decision(group)) for group in groups],
            fronts=_fronts(groups, rows),
            displacement=[_displacement(grid, axis) for axis in axes_of(grid)],
            displacement_table=_displacement_table(grid),
            displacement_at=_taken_at(data.get("grid_at")),
            regions=_regions(groups),
            fused=_fused(data.get("fused") or ()),
            fused_at=_taken_at(data.get("fused_at")),
            traffic=PageChart("", (("", traffic_chart(passes), _traffic_text(passes)),), _traffic_table(passes))
            if passes
            else None,
            measures=[(name, measure_label(name).partition(",")[0]) for name in MEASURES],
            clock=_CLOCKS.get(data.get("clock"), str(data.get("clock"))),
            clock_note=(data.get("clocks") or {}).get("note") or "",
            machine=data.get("machine") or {},
            version=data.get("hmdwarp") or "–",
            light=css_variables(dark=False),
            dark=css_variables(dark=True),
        )
    )


def _unique(rows: Iterable[Row], key: str) -> list[Any]:
    return list(dict.fromkeys(row[key] for row in rows))


def _count(number: int, word: str) -> str:
    return f"{number} {word}{'' if number == 1 else 's'}"


def _title(rows: Sequence[Row], groups: Sequence[Case]) -> tuple[str, str]:
    warps, fills = len(_unique(rows, "warp")), len(_unique(rows, "fill"))
    return _count(warps, "warp") + (
        f" × {_count(fills, 'fill')}" if fills > 1 else ""
    ), f"in {_count(len(groups), 'case')}"


def _facts(rows: Sequence[Row], groups: Sequence[Case]) -> list[tuple[str, str]]:
    facts = [
        ("recordings", sequence_text([str(trace) for trace in _unique(rows, "trace")])),
        ("latencies", sequence_text([f"{latency:g} ms" for latency in _unique(rows, "latency_ms")])),
        ("fills", sequence_text(_unique(rows, "fill"))),
    ]
    return [(label, text) for label, text in facts if text] + [("", text) for text in common(rows)]


def _tiles(data: Mapping[str, Any], rows: Sequence[Row]) -> list[dict[str, str]]:
    clocks = data.get("clocks") or {}
    gpu, wall = clocks.get("gpu_ms"), clocks.get("wall_ms")
    both = " / ".join("–" if value is None else f"{value:.3g}" for value in (gpu, wall))
    seconds = data.get("seconds")
    tiles = [
        (
            "Combinations",
            str(len(rows)),
            "",
            f"run in {seconds / 60:.1f} min" if seconds else "warp, fill, recording, latency",
        ),
        ("Clock", {"gpu": "GPU", "wall": "wall"}.get(data.get("clock"), "?"), "", _CLOCKS.get(data.get("clock"), "")),
        ("One pass, two clocks", both, "ms", "GPU timer / wall clock; where they agree, the timer is real"),
    ]
    if data.get("copy_gb_s"):
        tiles.append(
            (
                "Copy bandwidth",
                f"{data['copy_gb_s']:.1f}",
                "GB/s",
                "measured on this device; the bounds below follow from it",
            )
        )
    return [dict(zip(("label", "text", "unit", "note"), tile, strict=True)) for tile in tiles]


def _notes(data: Mapping[str, Any], rows: Sequence[Row]) -> list[str]:
    """Each note once, those of the bench first; a row's with the rows that made it, unless many did."""
    found: dict[str, list[str]] = {str(note): [] for note in data.get("notes") or ()}
    for row in rows:
        for note in row.get("notes") or ():
            found.setdefault(str(note), []).append(f"{row_name(row)}, {row['trace']}, {row['latency_ms']:g} ms")
    return [
        f"{note} ({'; '.join(where)})" if 0 < len(where) <= 3 else _many(note, len(where))
        for note, where in found.items()
    ]


def _many(note: str, count: int) -> str:
    return f"{note} ({count} combinations)" if count else note


def _choice(choice: Mapping[str, Any] | None) -> dict[str, Any] | None:
    if not choice:
        return None
    settings = choice.get("settings")
    settings = dict(settings) if isinstance(settings, Mapping) else {"settings": settings} if settings else {}
    settings |= {key: value for key, value in choice.items() if key not in _TOLD_OF_A_CHOICE and value is not None}
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
    return f"FLIP {COLUMNS['flip'].figure.text(entry.get('flip'))}, PSNR {COLUMNS['psnr_db'].figure.text(entry.get('psnr_db'))} dB"


def _gain(choice: Mapping[str, Any], step: Mapping[str, Any]) -> str:
    parts = []
    if choice.get("flip") and step.get("flip") is not None:
        parts.append(f"{100 * (1 - step['flip'] / choice['flip']):+.0f} % of the FLIP error removed".replace("+", ""))
    if choice.get("psnr_db") is not None and step.get("psnr_db") is not None:
        parts.append(f"{step['psnr_db'] - choice['psnr_db']:+.2f} dB")
    parts.append(f"{step['total_ms'] - choice['total_ms']:+.2f} ms")
    return ", ".join(parts)


def _line(texts: Sequence[str], words: int, marked: bool = False) -> Line:
    return Line(tuple(Cell(text, number >= words) for number, text in enumerate(texts)), marked)


def _decision(case: Case) -> PageTable:
    columns = [column(name) for name in DECISION]
    best = {id(row) for row in case.front()}
    lines = [Line(tuple(Cell(c.text(row), c.is_number) for c in columns), id(row) in best) for row in case.ordered()]
    heads = tuple((c.figure.label, c.figure.unit) for c in columns)
    return PageTable(f"{case.label}, least FLIP first", heads, tuple(lines), has_marks=True)


def _winners(groups: Sequence[Case]) -> PageTable:
    """Case by case: the most accurate row, and the most accurate that is no slower than the thesis's pipeline."""
    lines, has_limit = [], False
    for group in groups:
        measured = [row for row in group.ordered() if row["quality"]["flip"]["mean"] is not None]
        limit = next((_total(row) for row in measured if (row["warp"], row["fill"]) == _YARDSTICK), None)
        within = [row for row in measured if limit is not None and _total(row) is not None and _total(row) <= limit]
        has_limit |= limit is not None
        lines.append(
            _line([group.label, *_told(measured), *_told(within), "–" if limit is None else f"{limit:.2f}"], 1)
        )
    heads = [("case", ""), ("most accurate", ""), ("time", "ms"), ("FLIP", "")]
    heads += [("best no slower than forward + interpolate", ""), ("time", "ms"), ("FLIP", ""), ("that takes", "ms")]
    shown = len(heads) if has_limit else 4
    lines = [
        Line(tuple(Cell(cell.text, n not in (0, 1, 4)) for n, cell in enumerate(line.cells[:shown]))) for line in lines
    ]
    return PageTable("The most accurate of each case", tuple(heads[:shown]), tuple(lines))


def _total(row: Row) -> float | None:
    return row["time_ms"]["total"]["median"]


def _told(rows: Sequence[Row]) -> list[str]:
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
    """FLIP at the worse end of each axis, warp by warp."""
    axes = axes_of(grid)
    lines_of = {axis: curves(grid, axis) for axis in axes}
    warps = list(dict.fromkeys(row["warp"] for row in grid))
    if not warps:
        return None

    def worse_end(axis: str, warp: str) -> str:
        points = lines_of[axis].get(warp, ())
        return f"{max(points[0, 1], points[-1, 1]):.3f}" if len(points) else "–"

    def reach(axis: str) -> str:
        return f"±{max(abs(row['offset']) for row in grid if row['axis'] == axis):g} {'°' if is_turn(axis) else 'm'}"

    lines = tuple(_line([warp, *(worse_end(axis, warp) for axis in axes)], 1) for warp in warps)
    return PageTable(
        "FLIP at the worse end of each axis", (("warp", ""), *((axis, reach(axis)) for axis in axes)), lines
    )


def _regions(groups: Sequence[Case]) -> list[PageChart]:
    charts = []
    for group in groups:
        if any(region_parts(row) for row in group.rows):
            words = f"Error by region, {group.label}: see the table below"
            charts.append(PageChart(group.label, (("", regions_chart(group), words),), _regions_table(group)))
    return charts


def _regions_table(case: Case) -> PageTable:
    names = [f"{region}_{figure}" for region in REGIONS for figure in ("share", "flip", "psnr_db")]
    columns = [column("warp"), column("fill"), *(column(name) for name in names)]
    lines = tuple(_line([c.text(row) for c in columns], 2) for row in case.ordered() if region_parts(row))
    return PageTable(f"Error by region, {case.label}", tuple((c.figure.label, c.figure.unit) for c in columns), lines)


def _fused(rows: Iterable[Mapping[str, Any]]) -> PageTable | None:
    heads: list[tuple[str, str]] = [("warp", ""), ("fused", "ms"), ("separate", "ms"), ("speed-up", "×")]
    figures: list[tuple[str, str, Callable[[float], str]]] = [
        ("psnr_db", "PSNR", lambda v: f"{v:.2f}"), ("flip", "FLIP", lambda v: f"{v:.3f}"), ("sharpness", "sharpness", lambda v: f"{v:.2f}"),
    ]  # fmt: skip
    for name, label, _ in figures:
        heads += [
            (f"{label} fused", "dB" if name == "psnr_db" else ""),
            (f"{label} separate", "dB" if name == "psnr_db" else ""),
        ]
    lines = []
    for row in rows:
        texts = [str(row["warp"]), *(_number(row.get(name)) for name in ("fused_ms", "separate_ms", "speedup"))]
        for name, _, form in figures:
            pair = row.get(name) or {}
            texts += ["–" if pair.get(side) is None else form(pair[side]) for side in ("fused", "separate")]
        lines.append(_line(texts, 1))
    return PageTable("Warp and lens in one resample, against two", tuple(heads), tuple(lines)) if lines else None


def _taken_at(at: Mapping[str, Any] | None) -> str:
    """Where a section was measured, which is not in every case of the bench: 'scene room, 400x400, left eye'."""
    if not at:
        return ""
    parts = [f"scene {at['scene']}"]
    if "trace" in at:
        parts.append(f"{at['trace']}, {at['latency_ms']:g} ms")
    parts.append("x".join(map(str, at["size"])))
    return ", ".join([*parts, *([f"lens {at['lens']}"] if "lens" in at else []), f"{at['eye']} eye"])


def _number(value: float | None, digits: int = 2) -> str:
    return "–" if value is None else f"{value:.{digits}f}"


def _traffic_table(passes: Sequence[Any]) -> PageTable:
    heads = (("pass", ""), ("size", ""), ("moves", "MB"), ("bound", "ms"), ("takes", "ms"), ("times the bound", ""))
    lines = tuple(
        _line([p.label, p.size, *map(_number, (p.bytes / 1e6, p.bound_ms, p.median_ms)), _number(p.times_bound, 1)], 2)
        for p in passes
    )
    return PageTable("What each pass moves and takes", heads, lines)


def _traffic_text(passes: Sequence[Any]) -> str:
    return "Time of each pass and its bound: " + ", ".join(f"{p.label} {p.times_bound:.1f} times" for p in passes)
