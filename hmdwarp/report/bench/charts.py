"""The charts of a bench: error against time, against displacement and by region; memory traffic."""

from __future__ import annotations

import io
import os
from collections.abc import Iterable, Mapping, Sequence
from statistics import median
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...metrics import PRIMARY, REGIONS, error_and_time, metrics
from ..charts import (
    MARKER_PT,
    Style,
    axes_in,
    canvas,
    draw_front,
    draw_names,
    drawing,
    dress,
    empty_figure,
    legend,
    mark,
    name_rows,
    not_measured,
    plain_log_ticks,
    scale_axis,
    svg_text,
)
from ..files import write_bytes
from ..label_places import spread
from ..style import HATCHES, PAGE, PAPER, Palette, dashes_of, markers_of, warp_of
from .rows import Case, Row, cases, measure_label

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

GridRow = Mapping[str, Any]

AXES = ("x", "y", "z", "yaw", "pitch", "roll")
_MEANINGS = {
    "x": "to the right", "y": "up", "z": "backwards",
    "yaw": "turned to the left", "pitch": "looking up", "roll": "tilted to the left",
}  # fmt: skip
_LINE_PT = 10.5  # between two names
_PLOT_IN, _BELOW_IN, _ABOVE_IN = 3.3, 0.5, 0.12
_CHAR_PT = 5.6  # width of DejaVu Sans at 9 points, on the safe side
_LINE_IN = 0.21
_WIDTH_IN = 9.6
_REGION_MARKERS = ("s", "D", "^", "o")
_KINDS = ("client_depth", "warp", "fill", "effects", "lens")
_HEIGHT_IN = 4.2
_WARPS_IN = 1.65  # width of the list of warps with their colours
_ABOVE: Style = {"xycoords": "axes fraction", "textcoords": "offset points"}
_KEY_IN = 0.32  # of a picture's height; enough for one line, or two of small text
_COLOURS_A_LINE = 7
_KEY: Style = {
    "borderaxespad": 0.1, "handletextpad": 0.3, "columnspacing": 1.2, "borderpad": 0.2, "handlelength": 1.5,
}  # fmt: skip


def pareto_chart(case: Case, measure: str = PRIMARY, *, markers: Mapping[str, str] | None = None) -> str:
    """Draw one case as an <svg> element: mean error against median total time per eye.

    Time is logarithmic. The mark of a point says which fill it has; a warp has a colour, its name
    beside its best point, and a thin line to its others: no one has to tell two colours apart.
    Points of the front are filled, their names bold, and a line joins them: nothing lies below and
    left of it (above, for PSNR).
    Rows without a measurement are left out; a chart of nothing says so. markers: of the fills,
    where several charts are to share them.
    """
    markers = markers or markers_of(row["fill"] for row in case.rows)
    box = (0.62, 0.5, _WIDTH_IN - _WARPS_IN, _HEIGHT_IN - 0.36)
    with canvas((case.label, measure, _content(case, measure)), (_WIDTH_IN, _HEIGHT_IN), box=box) as axes:
        _draw_case(axes, case, measure, markers, PAGE)
        here = {fill: marker for fill, marker in markers.items() if fill in {row["fill"] for row in case.rows}}
        legend(axes, _key(here, PAGE), loc="lower left", bbox_to_anchor=(0, 1), ncols=5, **_KEY)
        corner = (1 - (_WARPS_IN - 0.12) / _WIDTH_IN, 1)
        figure: Any = axes.get_figure()
        legend(figure, _colours([case], measure, PAGE), loc="upper left", ncols=1, bbox_to_anchor=corner, **_KEY)
        return svg_text(figure)


def pareto_plot_png(
    path: str | os.PathLike[str], rows: Iterable[Row], *, measure: str = PRIMARY, columns: int | None = None
) -> None:
    """Write the same charts, one for each case, into one PNG for a README or a paper.

    It is 1600 pixels wide, on white. columns: charts side by side, by default two.
    Errors: as files.write_bytes.
    """
    write_bytes(path, _pareto_png(cases(rows), measure, columns))


def _pareto_png(groups: Sequence[Case], measure: str, columns: int | None) -> bytes:
    columns = columns or min(2, max(len(groups), 1))
    markers = markers_of(row["fill"] for group in groups for row in group.rows)
    lines = max(-(-len(groups) // columns), 1)
    width, height = 8 / columns, 3.3 if columns == 1 else 2.9
    with drawing((measure, [_content(group, measure) for group in groups]), font_size=8 if columns == 1 else 7):
        colours = _colours(groups, measure, PAPER)
        foot = 0.17 * -(-len(colours) // _COLOURS_A_LINE) + 0.1
        total = lines * height + _KEY_IN + foot
        figure = empty_figure(8, total)
        figure.patch.set_facecolor("white")
        if groups:
            place: Style = {"loc": "upper left", **_KEY}
            top, bottom = (0.5 / 8, 1 - 0.06 / total), (0.5 / 8, foot / total)
            legend(figure, _key(markers, PAPER), PAPER, bbox_to_anchor=top, ncols=5, **place)
            legend(figure, colours, PAPER, bbox_to_anchor=bottom, ncols=_COLOURS_A_LINE, **place)
        for number, group in enumerate(groups):
            left, top_in = number % columns * width, foot + (lines - number // columns) * height
            axes = axes_in(figure, (left + 0.55, top_in - height + 0.45, left + width - 0.1, top_in - 0.3))
            axes.annotate(group.label, (0, 1), (0, 5), **_ABOVE, weight="bold", color=PAPER.ink)
            dress(axes, PAPER)
            _draw_case(axes, group, measure, markers, PAPER)
        buffer = io.BytesIO()
        figure.savefig(buffer, format="png", dpi=200, metadata={"Software": None})
    return buffer.getvalue()


def pareto_text(case: Case, measure: str = PRIMARY) -> str:
    """Return the chart in words, for readers who cannot see it."""
    front = sorted(case.front(measure), key=_total)
    names = [f"{row['warp']} with fill {row['fill']} ({_total(row):.1f} ms)" for row in front]
    methods = ", ".join(names) or ("nothing was measured" if case.usable else "the bench's client can run none")
    return f"Error against time, {case.label}, {measure_label(measure)}. Pareto front, from quick to slow: {methods}."


def _total(row: Row) -> float:
    return float(row["time_ms"]["total"]["median"])


def _content(case: Case, measure: str) -> list[tuple[Any, ...]]:
    return [(row["warp"], row["fill"], *error_and_time(row, measure)) for row in case.rows]


def _draw_case(axes: Axes, case: Case, measure: str, markers: Mapping[str, str], palette: Palette) -> None:
    rows = [row for row in case.rows if None not in error_and_time(row, measure)]
    axes.set_xlabel("time per eye, all stages, in ms")
    axes.set_ylabel(measure_label(measure))
    if not rows:
        axes.set_xticks([])
        axes.set_yticks([])
        not_measured(axes, palette)
        return
    time = scale_axis(axes.xaxis, np.array([_total(row) for row in rows]), logarithmic=True)
    error = np.array([row["quality"][measure]["mean"] for row in rows])
    error = scale_axis(axes.yaxis, error, logarithmic=not metrics.get(measure).higher_is_better)
    best = {id(row) for row in case.front(measure)}
    is_best = np.array([id(row) in best for row in rows])
    line = draw_front(axes, time[is_best], error[is_best], palette, higher=metrics.get(measure).higher_is_better)
    for row, x, y, filled in zip(rows, time, error, is_best, strict=True):
        colour = palette.warp(row["warp"])
        style: Style = {
            "marker": markers[row["fill"]],
            "markersize": MARKER_PT,
            "markeredgewidth": 1.5,
            "color": colour,
            "linestyle": "none",
        }
        axes.plot(x, y, **style, markerfacecolor=colour if filled else "none", zorder=4 if filled else 3, clip_on=False)
    for name in dict.fromkeys(row["warp"] for row in rows):
        # A thin line ties all fills of a warp to its name: some see its colour as another's.
        own = sorted((x, y) for row, x, y in zip(rows, time, error, strict=True) if row["warp"] == name)
        axes.plot(*zip(*own, strict=True), color=palette.warp(name), linewidth=0.7, alpha=0.6, zorder=1)
    draw_names(axes, _names(rows, is_best, error, measure), np.stack([time, error], axis=1), is_best, line, palette)
    better = "better ↖" if metrics.get(measure).higher_is_better else "better ↙"
    axes.annotate(better, (1, 1), (0, 4), **_ABOVE, ha="right", color=palette.ink)


def _names(rows: Sequence[Row], is_best: np.ndarray, error: np.ndarray, measure: str) -> dict[str, list[int]]:
    """Return the points that each warp's name belongs to, by index.

    Those of the front, or the best of a warp that is not on it.
    """
    names: dict[str, list[int]] = {}
    for index, row in enumerate(rows):
        names.setdefault(row["warp"], []).append(index)
    cost = -error if metrics.get(measure).higher_is_better else error
    chosen = {}
    for name, found in names.items():
        best = [index for index in found if is_best[index]] or [min(found, key=lambda index: cost[index])]
        baseline = rows[best[0]].get("baseline")
        # Breaking a long name after its colon keeps it near its point.
        chosen[f"{name}\n({baseline})" if baseline else name.replace(":", ":\n", 1)] = best
    return chosen


def _key(markers: Mapping[str, str], palette: Palette) -> list[Any]:
    style: Style = {"markerfacecolor": "none", "markeredgewidth": 1.3, "linestyle": "none", "markersize": 6}
    fills = [mark(f"fill {fill}", marker=marker, color=palette.ink, **style) for fill, marker in markers.items()]
    return [*fills, mark("Pareto front (filled, bold)", color=palette.ink, linewidth=1.1, alpha=0.55)]


def _colours(groups: Sequence[Case], measure: str, palette: Palette) -> list[Any]:
    """Return each warp's name in its colour, the most accurate of the first case first."""
    names = dict.fromkeys(warp_of(row["warp"]) for group in groups for row in group.ordered(measure))
    return [mark(name, color=palette.warp(name), linestyle="none", marker="s", markersize=6) for name in names]


def is_turn(axis: str) -> bool:
    """Return whether offsets along this axis are in degrees; else they are in metres."""
    return axis in ("yaw", "pitch", "roll")


def axis_heading(axis: str) -> str:
    """Return the axis with the direction of its positive offsets, as OpenXR: +x right, +y up."""
    return f"{axis}: {_MEANINGS[axis]}" if axis in _MEANINGS else axis


def axes_of(grid: Iterable[GridRow]) -> list[str]:
    """Return the axes of the rows in the usual order, unknown ones last."""
    named = dict.fromkeys(row["axis"] for row in grid)
    return [axis for axis in AXES if axis in named] + [axis for axis in named if axis not in AXES]


def curves(grid: Iterable[GridRow], axis: str, measure: str = PRIMARY) -> dict[str, NDArray[np.float64]]:
    """Return (n, 2) for each warp: the measured offsets and errors in order of offset."""
    out: dict[str, list[tuple[float, float]]] = {}
    for row in grid:
        if row["axis"] == axis:
            points = out.setdefault(row["warp"], [])
            if row.get(measure) is not None:
                points.append((row["offset"], row[measure]))
    return {warp: np.array(sorted(points), dtype=np.float64).reshape(-1, 2) for warp, points in out.items()}


def displacement_chart(grid: Sequence[GridRow], axis: str, measure: str = PRIMARY) -> str:
    """Draw one axis as an <svg> element.

    The axes in metres share one scale of error, those in degrees another. Names stand at the right
    end of the lines, in their order, with an arrow where the line has left the chart, as `none`
    does.
    """
    lines = {warp: points for warp, points in curves(grid, axis, measure).items() if len(points)}
    height_in = max(3.0, (len(lines) * _LINE_PT + 60) / 72)
    names_in = max(map(len, lines), default=0) * _CHAR_PT / 72 + 0.45
    box = (0.6, _BELOW_IN, 0.6 + _PLOT_IN, height_in - _ABOVE_IN)
    labels: Style = {"x": f"offset in {'degrees' if is_turn(axis) else 'metres'}", "y": measure_label(measure)}
    content = (axis, measure, [(warp, points.tolist()) for warp, points in lines.items()])
    with canvas(content, (0.6 + _PLOT_IN + names_in, height_in), box=box, **labels) as axes:
        if lines:
            axes.set_ylim(_limits(grid, axis, measure))
            _draw_lines(axes, lines, dashes_of(dict.fromkeys(row["warp"] for row in grid)), height_in)
        else:
            not_measured(axes)
        return svg_text(axes.get_figure())


def displacement_text(grid: Sequence[GridRow], axis: str, measure: str = PRIMARY) -> str:
    """Return the chart in words, for readers who cannot see it: the order of the warps."""
    ends = {warp: points[-1, 1] for warp, points in curves(grid, axis, measure).items() if len(points)}
    names = [f"{warp} {ends[warp]:.3g}" for warp in sorted(ends, key=ends.__getitem__, reverse=True)]
    order = ", ".join(names) or "nothing"
    return (
        f"Error against offset, {axis_heading(axis)}, {measure_label(measure)}. At the right end, from above: {order}."
    )


def _limits(grid: Sequence[GridRow], axis: str, measure: str) -> tuple[float, float]:
    """Return the range of all warps but `none`, on all axes of this kind.

    `none` may leave it: in its range the others could not be told apart.
    """
    rows = [row for row in grid if row.get(measure) is not None and is_turn(row["axis"]) == is_turn(axis)]
    values = [row[measure] for row in rows if row["warp"] != "none"] or [row[measure] for row in rows]
    low, high = min(values), max(values)
    margin = max(0.06 * (high - low), 1e-6)
    return (0 if measure == "flip" else low - margin), high + margin


def _draw_lines(
    axes: Axes, lines: Mapping[str, NDArray[np.float64]], dashes: Mapping[str, Any], height_in: float
) -> None:
    for warp, points in lines.items():
        style = {"color": PAGE.warp(warp), "linestyle": dashes[warp], "linewidth": 1.5}
        axes.plot(*points.T, **style, marker="o" if len(points) == 1 else "", markersize=4)
    axes.margins(x=0)
    right = max(points[-1, 0] for points in lines.values())
    low, high = axes.get_ylim()
    axes.set_xlim(right=right)
    area_pt = 72 * (height_in - _BELOW_IN - _ABOVE_IN)
    ends = np.array([points[-1, 1] for points in lines.values()])
    wanted = np.clip((ends - low) / (high - low), 0, 1) * area_pt
    heights = spread(wanted, _LINE_PT, 0, area_pt)
    for warp, end, height in zip(lines, ends, heights, strict=True):
        # A short line in the warp's own colour and dash ties the name to its curve, as its legend.
        tie = {
            "arrowstyle": "-",
            "color": PAGE.warp(warp),
            "linestyle": dashes[warp],
            "linewidth": 1.2,
            "relpos": (0, 0.5),
        }
        name = warp + (" ↑" if end > high else " ↓" if end < low else "")
        axes.annotate(
            name, (lines[warp][-1, 0], np.clip(end, low, high)), (1.09, height / area_pt),
            xycoords="data", textcoords=axes.transAxes,
            va="center", ha="left", color=PAGE.ink, annotation_clip=False,
            arrowprops={**tie, "shrinkA": 1, "shrinkB": 0},
        )  # fmt: skip


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
        _stack(left, [[added for added, _ in parts] for _, parts in measured])
        _dots(right, [[flip for _, flip in parts] for _, parts in measured])
        name_rows(left, names)
        for axes in (left, right):
            axes.set_xlim(left=0)
        _region_key(figure)
        return svg_text(figure)


def _stack(axes: Axes, added: Sequence[Sequence[float]]) -> None:
    values = np.array(added)
    starts = np.cumsum(values, axis=1) - values
    for number in range(len(REGIONS)):
        axes.barh(
            range(len(values)), values[:, number], left=starts[:, number], height=0.66, color=PAGE.regions[number],
            hatch=HATCHES[number], edgecolor=PAGE.ink, linewidth=0.5,
        )  # fmt: skip


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


def _region_key(figure: Figure) -> None:
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


@attrs.frozen
class Traffic:
    """One pass at one size, per eye."""

    kind: str
    name: str
    size: str
    # Bytes moved, the time that alone would take, and the time taken.
    bytes: float
    bound_ms: float
    median_ms: float

    @property
    def label(self) -> str:
        """Kind and name: 'warp forward', 'fill none'; the kind alone where it has one pass."""
        return self.kind if self.kind == self.name else f"{self.kind} {self.name}"

    @property
    def times_bound(self) -> float:
        """Time over bound; infinite for a pass that moves nothing."""
        return self.median_ms / self.bound_ms if self.bound_ms > 0 else float("inf")


def traffic(rows: Iterable[Row]) -> list[Traffic]:
    """Return each pass once for each size, with medians over its rows.

    Warps come first, then fills and lenses, each from quick to slow.
    """
    entries_of: dict[tuple[str, str, str], list[Any]] = {}
    for row in rows:
        for entry in row.get("passes") or ():
            if entry.get("median_ms") is not None and entry.get("bound_ms") is not None:
                kind = entry["name"]
                size = "x".join(map(str, row["size"]))
                entries_of.setdefault((kind, str(row.get(kind, kind)), size), []).append(entry)
    out = [
        Traffic(*key, *(float(median(entry[name] for entry in entries)) for name in ("bytes", "bound_ms", "median_ms")))
        for key, entries in entries_of.items()
    ]
    order = {kind: number for number, kind in enumerate(_KINDS)}
    return sorted(out, key=lambda t: (t.size, order.get(t.kind, len(order)), t.median_ms))


def traffic_chart(passes: Sequence[Traffic]) -> str:
    """Draw an <svg> element: each pass's bound (a bar across), its time (a dot) and their ratio.

    Time is logarithmic.
    """
    size_in = (_WIDTH_IN, 0.85 + _LINE_IN * max(len(passes), 2))
    content = [attrs.astuple(entry) for entry in passes]
    with canvas(content, size_in, x="time per eye in ms", grid="x") as axes:
        figure: Any = axes.get_figure()
        shown = [entry for entry in passes if entry.bound_ms > 0 and entry.median_ms > 0]
        if not shown:
            not_measured(axes)
            return svg_text(figure)
        axes.set_xscale("log")
        for y, entry in enumerate(shown):
            _traffic_line(axes, y, entry)
        name_rows(axes, [entry.name if entry.kind == "warp" else entry.label for entry in shown])
        low, high = axes.get_xlim()
        axes.set_xlim(low, max(high * 1.3, low * 4))
        plain_log_ticks(axes.xaxis, (1, 2, 5))
        bound: Style = {"marker": "|", "markersize": 11, "markeredgewidth": 1.8, "linestyle": "none"}
        key = [mark("bound by memory traffic", **bound), mark("time taken", marker="o", markersize=6, linestyle="none")]
        legend(figure, key, loc="outside upper left", ncols=2)
        return svg_text(figure)


def _traffic_line(axes: Axes, y: int, entry: Traffic) -> None:
    colour = PAGE.warp(entry.name) if entry.kind == "warp" else PAGE.ink
    bound: Style = {"marker": "|", "markersize": 11, "markeredgewidth": 1.8, "color": PAGE.ink, "linestyle": "none"}
    axes.plot([entry.bound_ms, entry.median_ms], [y, y], color=colour, linewidth=1.6, zorder=2)
    axes.plot(entry.bound_ms, y, **bound, zorder=3)
    axes.plot(entry.median_ms, y, marker="o", markersize=6, color=colour, linestyle="none", zorder=4)
    text: Style = {"textcoords": "offset points", "va": "center", "color": PAGE.ink}
    axes.annotate(f"{entry.times_bound:.1f}×", (max(entry.median_ms, entry.bound_ms), y), (8, 0), **text)
