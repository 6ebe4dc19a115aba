"""bench.html: tables, charts and a choice of method, as data for the page builder."""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np
from markupsafe import Markup

from ...metrics import PRIMARY, REGIONS, Figure, error_and_time, metrics, metrics_in_order
from ..charts import (
    MARKER_PT,
    Style,
    axes_in,
    canvas,
    draw_front,
    draw_numbers,
    drawing,
    dress,
    empty_figure,
    legend,
    mark,
    name_rows,
    not_measured,
    png_of,
    scale_axis,
    svg_text,
)
from ..files import write_bytes
from ..page import (
    CLOCK_NAMES,
    Chart,
    Choice,
    Fold,
    Page,
    Section,
    Text,
    Tile,
    fact,
    machine_pairs,
    minutes,
    notes_section,
    reading_section,
    texts,
)
from ..run_texts import Table, axes_of_traces, counted, listed, plain
from ..style import HATCHES, PAGE, PAPER, Palette, markers_of
from .rows import (
    COLUMNS,
    Case,
    Column,
    Row,
    at,
    cases,
    choice_terms,
    common,
    decision,
    marked_how,
    measure_label,
    table_of,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_LINE_IN = 0.21
_WIDTH_IN = 9.6
_REGION_MARKERS = ("s", "D", "^", "o")
_HEIGHT_IN = 4.2
_PLOT_IN, _CHAR_IN = 7.7, 0.078  # right end of the axes; width of a letter in the list of warps
_ABOVE: Style = {"xycoords": "axes fraction", "textcoords": "offset points"}
_KEY_IN = 0.32  # of a picture's height; enough for one line, or two of small text
_PNG_CHARS = 150  # of small text, in a line of the picture
_KEY: Style = {
    "borderaxespad": 0.1, "handletextpad": 0.3, "columnspacing": 1.2, "borderpad": 0.2, "handlelength": 1.5,
}  # fmt: skip


def pareto_chart(case: Case, measure: str = PRIMARY, *, markers: Mapping[str, str] | None = None) -> str:
    """Draw one case as an <svg> element: mean error against median total time per eye.

    Time is logarithmic. The mark of a point says which fill it has; a warp has a colour, a number
    beside its best point, and a thin line to its others: no one has to tell two colours apart.
    Points of the front are filled, their numbers bold, and a line joins them: nothing lies below
    and left of it (above, for PSNR).
    Rows without a measurement are left out; a chart of nothing says so. markers: of the fills,
    where several charts are to share them.
    """
    markers = markers or markers_of(row["fill"] for row in case.rows)
    numbers = _numbers([case], measure)
    names = _names(numbers, [case], PAGE)
    height_in = max(_HEIGHT_IN, 0.19 * len(names) + 0.2)
    width_in = _PLOT_IN + 0.4 + _CHAR_IN * max((len(name.get_label()) for name in names), default=0)
    box = (0.62, 0.5, _PLOT_IN, height_in - 0.36)
    with canvas((case.label, measure, _content(case, measure)), (width_in, height_in), box=box) as axes:
        _draw_case(axes, case, measure, markers, numbers, PAGE)
        here = {fill: marker for fill, marker in markers.items() if fill in {row["fill"] for row in case.rows}}
        legend(axes, _key(here, PAGE), loc="lower left", bbox_to_anchor=(0, 1), ncols=5, **_KEY)
        figure: Any = axes.get_figure()
        legend(figure, names, loc="upper left", ncols=1, bbox_to_anchor=((_PLOT_IN + 0.1) / width_in, 1), **_KEY)
        return svg_text(figure)


def pareto_plot_png(
    path: str | os.PathLike[str], rows: Iterable[Row], *, measure: str = PRIMARY, columns: int | None = None
) -> None:
    """Write the same charts, one for each case, into one PNG for a README or a paper.

    It is 1600 pixels wide, on white. columns: charts side by side, by default two.
    Errors: as files.write_bytes.
    """
    groups = cases(rows)
    columns = columns or min(2, max(len(groups), 1))
    markers = markers_of(row["fill"] for group in groups for row in group.rows)
    lines = max(-(-len(groups) // columns), 1)
    width, height = 8 / columns, 3.3 if columns == 1 else 2.9
    with drawing((measure, [_content(group, measure) for group in groups]), font_size=8 if columns == 1 else 7):
        numbers = _numbers(groups, measure)
        names = _names(numbers, groups, PAPER)
        ncols = max(1, int(_PNG_CHARS / (8 + max((len(name.get_label()) for name in names), default=0))))
        foot = 0.17 * -(-len(names) // ncols) + 0.1
        total = lines * height + _KEY_IN + foot
        figure = empty_figure(8, total)
        figure.patch.set_facecolor("white")
        if groups:
            place: Style = {"loc": "upper left", **_KEY}
            top, bottom = (0.5 / 8, 1 - 0.06 / total), (0.5 / 8, foot / total)
            legend(figure, _key(markers, PAPER), PAPER, bbox_to_anchor=top, ncols=5, **place)
            legend(figure, names, PAPER, bbox_to_anchor=bottom, ncols=ncols, **place)
        for number, group in enumerate(groups):
            left, top_in = number % columns * width, foot + (lines - number // columns) * height
            axes = axes_in(figure, (left + 0.55, top_in - height + 0.45, left + width - 0.1, top_in - 0.3))
            axes.annotate(group.label, (0, 1), (0, 5), **_ABOVE, weight="bold", color=PAPER.ink)
            dress(axes, PAPER)
            _draw_case(axes, group, measure, markers, numbers, PAPER)
        write_bytes(path, png_of(figure, 200))


def pareto_text(case: Case, measure: str = PRIMARY) -> str:
    """Return the chart in words, for readers who cannot see it."""
    front = sorted(case.front(measure), key=_total_ms)
    names = [f"{row['warp']} with fill {row['fill']} ({_total_ms(row):.1f} ms)" for row in front]
    methods = ", ".join(names) or ("nothing was measured" if case.usable else "the bench's client can run none")
    return f"Error against time, {case.label}, {measure_label(measure)}. Pareto front, from quick to slow: {methods}."


def _total_ms(row: Row) -> float:
    return float(row["time_ms"]["total"]["median"])


def _content(case: Case, measure: str) -> list[tuple[Any, ...]]:
    return [(row["warp"], row["fill"], *error_and_time(row, measure)) for row in case.rows]


def _draw_case(
    axes: Axes, case: Case, measure: str, markers: Mapping[str, str], numbers: Mapping[str, int], palette: Palette
) -> None:
    rows = [row for row in case.rows if None not in error_and_time(row, measure)]
    axes.set_xlabel("time per eye, all stages, in ms")
    axes.set_ylabel(measure_label(measure))
    if not rows:
        axes.set_xticks([])
        axes.set_yticks([])
        not_measured(axes, palette)
        return
    time = scale_axis(axes.xaxis, np.array([_total_ms(row) for row in rows]), logarithmic=True)
    error = np.array([row["quality"][measure]["mean"] for row in rows])
    error = scale_axis(axes.yaxis, error, logarithmic=not metrics.get(measure).higher_is_better)
    best = {id(row) for row in case.front(measure)}
    is_best = np.array([id(row) in best for row in rows])
    draw_front(axes, time[is_best], error[is_best], palette, higher=metrics.get(measure).higher_is_better)
    for row, x, y, filled in zip(rows, time, error, is_best, strict=True):
        colour = palette.warp(row["warp"])
        style: Style = {"marker": markers[row["fill"]], "markersize": MARKER_PT, "markeredgewidth": 1.5}
        style |= {"color": colour, "linestyle": "none"}
        axes.plot(x, y, **style, markerfacecolor=colour if filled else "none", zorder=4 if filled else 3, clip_on=False)
    for name in dict.fromkeys(row["warp"] for row in rows):
        # A thin line ties all fills of a warp to its number: some see its colour as another's.
        own = sorted((x, y) for row, x, y in zip(rows, time, error, strict=True) if row["warp"] == name)
        axes.plot(*zip(*own, strict=True), color=palette.warp(name), linewidth=0.7, alpha=0.6, zorder=1)
    higher = metrics.get(measure).higher_is_better
    numbered: dict[int, int] = {}
    for name, number in numbers.items():
        its = [index for index, row in enumerate(rows) if row["warp"] == name]
        least = [max(its, key=lambda index: error[index] if higher else -error[index])] if its else []
        numbered |= dict.fromkeys([index for index in its if is_best[index]] or least, number)
    draw_numbers(axes, numbered, np.stack([time, error], axis=1), is_best, palette)
    better = "better ↖" if higher else "better ↙"
    axes.annotate(better, (1, 1), (0, 4), **_ABOVE, ha="right", color=palette.ink)


def _key(markers: Mapping[str, str], palette: Palette) -> list[Any]:
    style: Style = {"markerfacecolor": "none", "markeredgewidth": 1.3, "linestyle": "none", "markersize": 6}
    fills = [mark(f"fill {fill}", marker=marker, color=palette.ink, **style) for fill, marker in markers.items()]
    return [*fills, mark("Pareto front (filled, bold)", color=palette.ink, linewidth=1.1, alpha=0.55)]


def _numbers(groups: Sequence[Case], measure: str) -> dict[str, int]:
    """Return the number of each warp, the most accurate of the first case first."""
    names = dict.fromkeys(row["warp"] for group in groups for row in group.ordered(measure))
    return {name: number for number, name in enumerate(names, 1)}


def _names(numbers: Mapping[str, int], groups: Sequence[Case], palette: Palette) -> list[Any]:
    """Return the legend's entry of each number: the warp, and what it stands for, in its colour."""
    stands_for = {row["warp"]: row["baseline"] for group in groups for row in group.rows if row.get("baseline")}
    return [
        mark(
            f"{number} {name}" + (f" ({stands_for[name]})" if name in stands_for else ""),
            color=palette.warp(name), linestyle="none", marker="s", markersize=6,
        )
        for name, number in numbers.items()
    ]  # fmt: skip


def row_name(row: Row, with_fill: bool = True) -> str:
    """Return a row's strategy, or its warp, and its fill where there are several."""
    if row.get("strategy"):
        return str(row["strategy"])
    return f"{row['warp']} + {row['fill']}" if with_fill and row["fill"] != "none" else row["warp"]


def region_parts(row: Row) -> list[tuple[float, float | None]] | None:
    """Return what each region adds to FLIP (share of pixels x FLIP there), and FLIP there.

    None if not measured.
    """
    regions = row.get("regions") or {}
    if not all(name in regions for name in REGIONS):
        return None
    entries = [regions[name] for name in REGIONS]
    if all(entry.get("share") is None for entry in entries):
        return None
    return [((entry.get("share") or 0.0) * (entry.get("flip") or 0.0), entry.get("flip")) for entry in entries]


def regions_chart(case: Case) -> str:
    """Draw one case as an <svg> element: what each region adds to FLIP, and FLIP within each.

    The best row is on top.
    """
    measured = [(row, parts) for row in case.ordered() if (parts := region_parts(row))]
    with_fill = len({row["fill"] for row in case.rows}) > 1
    names = [row_name(row, with_fill) for row, _ in measured]
    size_in = (_WIDTH_IN, 0.85 + _LINE_IN * max(len(measured), 2))
    with drawing((case.label, names, [parts for _, parts in measured])):
        figure = empty_figure(*size_in, layout="constrained")
        left, right = figure.subplots(1, 2, sharey=True, width_ratios=(3, 2))
        for axes, label in ((left, "what each region adds to FLIP"), (right, "FLIP within each region")):
            dress(axes, grid="x")
            axes.set_xlabel(label)
        if not measured:
            not_measured(left)
            return svg_text(figure)
        values = np.array([[added for added, _ in parts] for _, parts in measured])
        starts = np.cumsum(values, axis=1) - values
        for number in range(len(REGIONS)):
            left.barh(
                range(len(values)), values[:, number], left=starts[:, number], height=0.66, color=PAGE.regions[number],
                hatch=HATCHES[number], edgecolor=PAGE.ink, linewidth=0.5,
            )  # fmt: skip
        _dots(right, [[flip for _, flip in parts] for _, parts in measured])
        name_rows(left, names)
        for axes in (left, right):
            axes.set_xlim(left=0)
        from matplotlib.legend_handler import HandlerTuple
        from matplotlib.patches import Patch

        handles = []
        for colour, hatch, marker in zip(PAGE.regions, HATCHES, _REGION_MARKERS, strict=True):
            patch = Patch(facecolor=colour, edgecolor=PAGE.ink, hatch=hatch, linewidth=0.5)
            handles.append((patch, mark(marker=marker, **_dot(colour))))
        labels = [name.replace("_", " ") for name in REGIONS]
        legend(
            figure, handles, labels=labels, handler_map={tuple: HandlerTuple(ndivide=None, pad=0.6)}, handlelength=3.2,
            loc="outside upper left", ncols=len(REGIONS),
        )  # fmt: skip
        return svg_text(figure)


def _dots(axes: Axes, flips: Sequence[Sequence[float | None]]) -> None:
    for y, values in enumerate(flips):
        there = [value for value in values if value is not None]
        if there:
            axes.plot([min(there), max(there)], [y, y], color=PAGE.grid, linewidth=2, zorder=1)
    for number, marker in enumerate(_REGION_MARKERS):
        points = [(value, y) for y, values in enumerate(flips) if (value := values[number]) is not None]
        axes.plot(
            [x for x, _ in points], [y for _, y in points], marker=marker, markersize=6, **_dot(PAGE.regions[number])
        )


def _dot(colour: str) -> Style:
    return {"color": colour, "markeredgecolor": PAGE.ink, "markeredgewidth": 0.7, "linestyle": "none"}


MEASURES = ("flip", "psnr_db")
_REFERENCE = ("forward", "interpolate")  # the pipeline of the thesis that this project began with
_KEYS_OF_A_CHOICE = {"budget_ms", "warp", "fill", "settings", "total_ms", "flip", "psnr_db", "sizes", "cases", "next"}


def bench_page(data: Mapping[str, Any]) -> Page:
    """Return the page from the content of bench.json.

    The same content gives the same page. Sections without data (no regions, no budget)
    are left out.
    """
    rows: list[Row] = list(data["rows"])
    groups = cases(rows)
    title = _title(rows, groups)
    clock_note = (data.get("clocks") or {}).get("note")
    rated = [("JOD", texts("bench")["notes"]["jod"])] if any("jod" in row for row in rows) else []
    explained = [(m.label, m.explanation) for m in metrics_in_order() if m.explanation and m.bench_rank is not None]
    rows_of: dict[str, list[str]] = {str(note): [] for note in data.get("notes") or ()}
    for row in rows:
        for note in row.get("notes") or ():
            rows_of.setdefault(str(note), []).append(f"{row_name(row)}, {row['trace']}, {row['latency_ms']:g} ms")
    where = {
        note: "; ".join(names) if len(names) <= 3 else f"{len(names)} combinations" for note, names in rows_of.items()
    }
    return Page(
        kind="bench",
        title=f"hmdwarp bench: {' '.join(title)}",
        heading=title,
        facts=_facts(rows, groups),
        command=data.get("command") or "",
        sections=(
            _choice(data.get("choice")),
            Section("", _tiles(data, rows), style="tiles", label="What was run"),
            Section("", [clock_note and Text(clock_note)], style="after"),
            notes_section([f"{note} ({names})" if names else note for note, names in where.items()]),
            suite_section(data.get("suite")),
            _tables(rows, groups),
            _fronts(groups, rows),
            _regions(groups),
            reading_section("bench", *explained, *rated),
        ),
        made_with=machine_pairs(data.get("hmdwarp") or "–", data.get("machine") or {}, data.get("clock")),
    )


def suite_section(entry: Mapping[str, Any] | None) -> Section | None:
    """Return the means of a suite over all heads and scenes; None for no suite."""
    if not entry:
        return None
    flip, psnr = (metrics.get(name).figure for name in ("flip", "psnr_db"))
    behind = attrs.evolve(flip, name="behind", label="FLIP behind the best")
    seen = attrs.evolve(psnr, name="where_seen_db", label="PSNR where seen")
    columns = [(flip, "mean"), (flip, "p95"), (behind, "mean"), (psnr, "mean"), (psnr, "p95"), (seen, "mean")]
    lines = [
        (
            f"{row['latency_ms']:g} ms",
            row_name(row),
            *_rank(row["rank"]),
            *(text for figure, which in columns for text in _with_interval(figure, row[figure.name], which)),
        )
        for row in entry["over_all"]
    ]
    heads = [("", ""), ("", ""), ("rank", "95 %"), ("best", "%")]
    for figure, which in columns:
        label = figure.label if which == "mean" else f"{figure.label} {which}"
        heads += [(label, figure.unit), ("95 %", figure.unit)]
    heading = f"Suite {entry['name']} {entry['version']}: over all heads and scenes"
    told = texts("bench")["notes"]
    floors = [
        f"{sequence['name']}: {'unknown' if (floor := sequence['noise_floor_db']) is None else f'{floor:g} dB'}"
        for sequence in entry.get("sequences", ())
    ]
    blocks = [Table.of("", heads, lines, label=heading, words=2), Text(told["suite"]), *_halves(entry["over_all"])]
    return Section(heading, [*blocks, floors and Text(f"{told['floors']} {listed(floors)}.")])


def _halves(rows: Sequence[Mapping[str, Any]]) -> list[Table | Text]:
    """Return the means in the half that parameters are fitted on, and in the one held out."""
    names = {"fit": "fitted on", "held_out": "held out"}
    columns = [Column.of_text("", value=lambda row: f"{row['latency_ms']:g} ms"), Column.of_text("", value=row_name)]
    for figure, (half, name) in itertools.product((metrics.get(name).figure for name in MEASURES), names.items()):
        of_half = attrs.evolve(figure, label=f"{figure.label}, {name}")
        columns.append(Column(of_half, at("halves", half, figure.name)))
    counts = [max((row["halves"][half]["cases"] for row in rows), default=0) for half in names]
    label = "By half: {} cases of scenes and heads that parameters are fitted on, {} of others".format(*counts)
    return [Text(f"{label}."), table_of("", columns, rows, label=label)] if any(counts) else []


def _rank(rank: Mapping[str, Any] | None) -> tuple[str, str]:
    if rank is None:
        return "–", "–"
    return " to ".join(map(str, dict.fromkeys(rank["interval"]))), f"{100 * rank['best']:.0f}"


def _with_interval(figure: Figure, entry: Mapping[str, Any] | None, which: str) -> tuple[str, str]:
    if entry is None:
        return "–", "–"
    interval = entry["interval" if which == "mean" else f"{which}_interval"]
    return figure.text(entry[which]), " to ".join(map(figure.text, interval)) if interval else "–"


def _unique(rows: Iterable[Row], key: str) -> list[Any]:
    return list(dict.fromkeys(row[key] for row in rows))


def _title(rows: Sequence[Row], groups: Sequence[Case]) -> tuple[str, str]:
    warps, fills = len(_unique(rows, "warp")), len(_unique(rows, "fill"))
    methods = counted(warps, "warp") + (f" × {counted(fills, 'fill')}" if fills > 1 else "")
    return methods, f"in {counted(len(groups), 'case')}"


def _facts(rows: Sequence[Row], groups: Sequence[Case]) -> list[str]:
    facts = [
        ("recordings", listed([str(trace) for trace in _unique(rows, "trace")])),
        *((f"axes of {trace}", axes) for trace, axes in axes_of_traces(rows).items()),
        ("latencies", listed([f"{latency:g} ms" for latency in _unique(rows, "latency_ms")])),
        ("fills", listed(_unique(rows, "fill"))),
    ]
    return [fact(label, text) for label, text in facts if text] + [fact("", text) for text in common(rows)]


def _tiles(data: Mapping[str, Any], rows: Sequence[Row]) -> list[Tile]:
    clocks = data.get("clocks") or {}
    gpu, wall = clocks.get("gpu_ms"), clocks.get("wall_ms")
    both = " / ".join("–" if value is None else f"{value:.3g}" for value in (gpu, wall))
    seconds, clock = data.get("seconds"), data.get("clock", "")
    ran = f"run in {minutes(seconds)}" if seconds else "warp, fill, recording, latency"
    return [
        Tile("Combinations", "", str(len(rows)), ran),
        Tile("Clock", "", {"gpu": "GPU", "wall": "wall"}.get(clock, "?"), CLOCK_NAMES.get(clock, "")),
        Tile("One pass, two clocks", "ms", both, "GPU timer / wall clock; where they agree, the timer is real"),
    ]


def _choice(choice: Mapping[str, Any] | None) -> Section | None:
    """Return the box with the method that was chosen within the budget, and the next step up."""
    if not choice:
        return None
    settings = choice.get("settings")
    settings = dict(settings) if isinstance(settings, Mapping) else {"settings": settings} if settings else {}
    settings |= {key: value for key, value in choice.items() if key not in _KEYS_OF_A_CHOICE and value is not None}
    figures = Markup("<b>{:.2f} ms</b>, {} ({})").format(choice["total_ms"], _figures(choice), choice_terms(choice))
    step, more = choice.get("next"), "Nothing measured is more accurate at any time."
    if step:
        named = Markup("The next step up: <b>{} + {}</b>, {:.2f} ms, {} ({}).")
        parts = []
        if choice.get("flip") and step.get("flip") is not None:
            parts.append(
                f"{100 * (1 - step['flip'] / choice['flip']):+.0f} % of the FLIP error removed".replace("+", "")
            )
        if choice.get("psnr_db") is not None and step.get("psnr_db") is not None:
            parts.append(f"{step['psnr_db'] - choice['psnr_db']:+.2f} dB")
        parts.append(f"{step['total_ms'] - choice['total_ms']:+.2f} ms")
        more = named.format(step["warp"], step["fill"], step["total_ms"], _figures(step), ", ".join(parts))
    blocks = [
        Text(f"{choice['warp']} + {choice['fill']}", "name"),
        settings and Text(", ".join(f"{name} {value}" for name, value in settings.items()), ""),
        Text(figures, ""),
        Text(more, ""),
    ]
    heading = f"The most accurate within {choice['budget_ms']:g} ms per eye on this machine"
    return Section(heading, blocks, style="answer")


def _figures(entry: Mapping[str, Any]) -> str:
    flip, psnr = (metrics.get(name).short_figure.text(entry.get(name)) for name in ("flip", "psnr_db"))
    return f"FLIP {flip}, PSNR {psnr} dB"


def _tables(rows: Sequence[Row], groups: Sequence[Case]) -> Section:
    note = texts("bench")["notes"]["table"].format(sure=marked_how(rows, mark="★ and bold"))
    folds = [
        Fold(group.label, [_decision(group)], f"{len(group.rows)} methods", is_open=number == 0)
        for number, group in enumerate(groups)
    ]
    return Section("The table to decide from", [_winners(groups), Text(note), *folds], id="table", link="Table")


def _decision(case: Case) -> Table:
    columns = [COLUMNS[name] for name in decision(case.rows)]
    return table_of(f"{case.label}, least FLIP first", columns, case.ordered(), marked=case.held(), has_marks=True)


def _winners(groups: Sequence[Case]) -> Table:
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
    figures = (("time", "ms"), ("FLIP", ""))
    heads = [("case", ""), ("most accurate", ""), *figures]
    heads += [("best no slower than forward + interpolate", ""), *figures, ("that takes", "ms")] if has_limit else []
    return Table.of("The most accurate of each case", heads, [line[: len(heads)] for line in lines], words=(0, 1, 4))


def _total(row: Row) -> float | None:
    total: float | None = row["time_ms"]["total"]["median"]
    return total


def _first(rows: Sequence[Row]) -> list[str]:
    if not rows:
        return ["–", "–", "–"]
    return [row_name(rows[0]), COLUMNS["total_ms"].text(rows[0]), COLUMNS["flip"].text(rows[0])]


def _fronts(groups: Sequence[Case], rows: Sequence[Row]) -> Section:
    markers = markers_of(row["fill"] for row in rows)
    known = [name for name in MEASURES if any(row["quality"][name]["mean"] is not None for row in rows)] or MEASURES
    charts = [
        Chart(
            group.label,
            tuple((name, pareto_chart(group, name, markers=markers), pareto_text(group, name)) for name in known),
        )
        for group in groups
    ]
    choice = [_measures("time", known)] if len(known) > 1 else []
    return Section("Error against time", [*choice, *charts], id="time", link="Error against time")


def _measures(section: str, names: Sequence[str] = MEASURES) -> Choice:
    return Choice(f"measure-{section}", [(name, measure_label(name).partition(",")[0]) for name in names])


def _regions(groups: Sequence[Case]) -> Section:
    folds: list[Fold] = []
    for group in groups:
        if any(region_parts(row) for row in group.rows):
            words = f"Error by region, {group.label}: see the table below"
            blocks = [Chart.of("", regions_chart(group), words), Fold("As a table", [_regions_table(group)])]
            folds.append(Fold(group.label, blocks, is_open=not folds))
    notes = texts("bench")["notes"]
    heading, note = "Where the error lies", Text(f"{notes['regions']} {notes['regions_chart']}")
    return Section(heading, [note, *folds] if folds else [], id="regions", link=heading)


def _regions_table(case: Case) -> Table:
    names = [f"{region}_{figure}" for region in REGIONS for figure in ("share", "flip", "psnr_db")]
    columns = [COLUMNS[name] for name in ("warp", "fill", *names)]
    return table_of(f"Error by region, {case.label}", columns, filter(region_parts, case.ordered()))
