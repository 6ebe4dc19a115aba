"""Error against time, with the Pareto front: the chart to choose a method from."""

from __future__ import annotations

import io
import os
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ...metrics import PRIMARY, error_and_time, metrics
from ..files import write_bytes
from ..style import PAGE, PAPER, Palette, Style, drawing, dress, markers_of, not_measured, svg_text
from .labels import groups_of, leaders, place_labels
from .rows import Case, Row, cases, measure_label

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_WIDTH_IN, _HEIGHT_IN = 9.6, 3.9
_MARKER_PT = 6.5
_CLEAR_PT = 4.5  # half the side of the square around a marker that no label covers
_SHARED_PT = 13.0  # twice a marker; points of one warp nearer than that share one name
_LEADER_PT = 2.5  # a label nearer than that to its marker needs no line to it
_ABOVE: Style = {"xycoords": "axes fraction", "textcoords": "offset points"}
_KEY_IN = 0.32  # of a picture's height; enough for one line, or two of small text
_MANY = 20  # points of one chart from which a picture has one chart a row
_PNG_DPI = 200


def pareto_chart(case: Case, measure: str = PRIMARY, *, markers: Mapping[str, str] | None = None) -> str:
    """Draw one case as an <svg> element: mean error against median total time per eye.

    Time is logarithmic. Every point is named. Points of the front are filled, their names bold, and
    a line joins them: nothing lies below and left of it (above, for PSNR). Rows without a
    measurement are left out; a chart of nothing says so. markers: of the fills, where several
    charts are to share them.
    """
    markers = markers or markers_of(row["fill"] for row in case.rows)
    with drawing((case.label, measure, _content(case, measure))):
        figure = _figure(_WIDTH_IN, _HEIGHT_IN)
        axes = _axes_in(figure, (0.62, 0.5, _WIDTH_IN - 0.12, _HEIGHT_IN - 0.36))
        _draw(axes, case, measure, markers, PAGE)
        here = {fill: marker for fill, marker in markers.items() if fill in {row["fill"] for row in case.rows}}
        axes.legend(handles=_key(here, PAGE), loc="lower left", bbox_to_anchor=(0, 1), ncols=4, **_key_style(PAGE))
        return svg_text(figure)


def pareto_plot_png(
    path: str | os.PathLike, rows: Iterable[Row], *, measure: str = PRIMARY, columns: int | None = None
) -> None:
    """Write the same charts, one for each case, into one PNG for a README or a paper.

    It is 1600 pixels wide, on white.

    columns: charts side by side, by default two, or one where they hold many points.
    Errors: as files.write_bytes.
    """
    write_bytes(path, _pareto_png(cases(rows), measure, columns))


def _pareto_png(groups: Sequence[Case], measure: str, columns: int | None) -> bytes:
    most = max((len(group.rows) for group in groups), default=0)
    columns = columns or (1 if most > _MANY or len(groups) < 2 else 2)
    markers = markers_of(row["fill"] for group in groups for row in group.rows)
    lines = max(-(-len(groups) // columns), 1)
    width, height = 8 / columns, 3.3
    with drawing((measure, [_content(group, measure) for group in groups]), font_size=8 if columns == 1 else 7.5):
        figure = _figure(8, lines * height + _KEY_IN)
        figure.patch.set_facecolor("white")
        if groups:
            anchor = (0.5 / 8, 1 - 0.06 / (lines * height + _KEY_IN))
            figure.legend(
                handles=_key(markers, PAPER), loc="upper left", bbox_to_anchor=anchor, ncols=4, **_key_style(PAPER)
            )
        for number, group in enumerate(groups):
            left, top = number % columns * width, (lines - number // columns) * height
            axes = _axes_in(figure, (left + 0.55, top - height + 0.45, left + width - 0.1, top - 0.3))
            axes.annotate(group.label, (0, 1), (0, 5), **_ABOVE, weight="bold", color=PAPER.ink, parse_math=False)
            _draw(axes, group, measure, markers, PAPER)
        buffer = io.BytesIO()
        figure.savefig(buffer, format="png", dpi=_PNG_DPI, metadata={"Software": None})
    return buffer.getvalue()


def pareto_text(case: Case, measure: str = PRIMARY) -> str:
    """Return the chart in words, for readers who cannot see it."""
    front = sorted(case.front(measure), key=_total)
    names = [f"{row['warp']} with fill {row['fill']} ({_total(row):.1f} ms)" for row in front]
    methods = ", ".join(names) or "nothing was measured"
    return f"Error against time, {case.label}, {measure_label(measure)}. Pareto front, from quick to slow: {methods}."


def _total(row: Row) -> float:
    return row["time_ms"]["total"]["median"]


def _content(case: Case, measure: str) -> list[tuple[Any, ...]]:
    return [(row["warp"], row["fill"], *error_and_time(row, measure)) for row in case.rows]


def _figure(width_in: float, height_in: float) -> Figure:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width_in, height_in))
    FigureCanvasAgg(figure)
    return figure


def _axes_in(figure: Figure, box: tuple[float, float, float, float]) -> Axes:
    """Add axes at a fixed place (left, bottom, right, top in inches): placing labels needs it."""
    width, height = figure.get_size_inches()
    left, bottom, right, top = box
    return figure.add_axes((left / width, bottom / height, (right - left) / width, (top - bottom) / height))


def _draw(axes: Axes, case: Case, measure: str, markers: Mapping[str, str], palette: Palette) -> None:
    rows = [row for row in case.rows if None not in error_and_time(row, measure)]
    dress(axes, palette)
    axes.set_xlabel("time per eye, all stages, in ms")
    axes.set_ylabel(measure_label(measure))
    if not rows:
        axes.set_xticks([])
        axes.set_yticks([])
        not_measured(axes, palette)
        return
    time = np.array([_total(row) for row in rows])
    error = np.array([row["quality"][measure]["mean"] for row in rows])
    _scale(axes.xaxis, time, logarithmic=True)
    _scale(axes.yaxis, error, logarithmic=not metrics.get(measure).higher_is_better and error.min() > 0)
    best = {id(row) for row in case.front(measure)}
    is_best = np.array([id(row) in best for row in rows])
    line = _draw_front(axes, time[is_best], error[is_best], measure, palette)
    for row, x, y, filled in zip(rows, time, error, is_best, strict=True):
        colour = palette.warp(row["warp"])
        style: Style = {
            "marker": markers[row["fill"]],
            "markersize": _MARKER_PT,
            "markeredgewidth": 1.5,
            "color": colour,
            "linestyle": "none",
        }
        axes.plot(x, y, **style, markerfacecolor=colour if filled else "none", zorder=4 if filled else 3, clip_on=False)
    _draw_names(axes, [row["warp"] for row in rows], np.stack([time, error], axis=1), is_best, line, palette)
    better = "better ↖" if metrics.get(measure).higher_is_better else "better ↙"
    axes.annotate(better, (1, 1), (0, 4), **_ABOVE, ha="right", color=palette.ink)


def _scale(axis: Any, values: np.ndarray, *, logarithmic: bool) -> None:
    """Set limits with a margin around the values, and plain numbers at the ticks.

    A time below a microsecond counts as one.
    """
    from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullLocator

    limits = axis.axes.set_xlim if axis.axis_name == "x" else axis.axes.set_ylim
    if not logarithmic:
        low, high = values.min(), values.max()
        margin = max(0.08 * (high - low), 0.5)
        limits(low - margin, high + margin)
        axis.set_major_locator(MaxNLocator(6))
        return
    low, high = np.log10(np.maximum([values.min(), values.max()], 1e-3))
    # At least a factor of four, so that two ticks are in it.
    margin = max(0.06 * (high - low), (np.log10(4) - (high - low)) / 2)
    scale = axis.axes.set_xscale if axis.axis_name == "x" else axis.axes.set_yscale
    scale("log")
    limits(10 ** (low - margin), 10 ** (high + margin))
    axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))


def _draw_front(axes: Axes, time: np.ndarray, error: np.ndarray, measure: str, palette: Palette) -> np.ndarray:
    """Draw the staircase that bounds these methods; return it as (m, 2) in data coordinates."""
    order = np.argsort(time, kind="stable")
    time, error = time[order], error[order]
    worst = axes.get_ylim()[0 if metrics.get(measure).higher_is_better else 1]
    x = np.concatenate([[time[0]], time, [axes.get_xlim()[1]]])
    y = np.concatenate([[worst], error, error[-1:]])
    axes.plot(x, y, drawstyle="steps-post", color=palette.ink, linewidth=1.1, alpha=0.55, zorder=2)
    return np.stack([np.repeat(x, 2)[1:], np.repeat(y, 2)[:-1]], axis=1)


def _draw_names(
    axes: Axes, names: list[str], points: np.ndarray, is_best: np.ndarray, line: np.ndarray, palette: Palette
) -> None:
    """Write each point's warp beside it; points of one warp that nearly coincide share a name."""
    to_points, box = 72 / axes.figure.dpi, axes.get_window_extent()
    area = (box.width * to_points, box.height * to_points)
    at = (axes.transData.transform(points) - (box.x0, box.y0)) * to_points
    bends = (axes.transData.transform(line) - (box.x0, box.y0)) * to_points
    groups = groups_of(names, at, _SHARED_PT)
    # Breaking a long name after its colon keeps it near its point.
    texts = [names[group[0]].replace(":", ":\n", 1) for group in groups]
    weights = ["bold" if is_best[group].any() else "normal" for group in groups]
    sizes = np.array([_size_pt(axes.figure, *pair) for pair in zip(texts, weights, strict=True)])
    corners = place_labels([at[group] for group in groups], sizes, area, clearance=_CLEAR_PT, line=bends)
    for group, text, weight, corner, size in zip(groups, texts, weights, corners, sizes, strict=True):
        style: Style = {
            "weight": weight,
            "ha": "center",
            "va": "center",
            "color": palette.ink,
            "parse_math": False,
            "zorder": 6,
        }
        x, y = (corner + size / 2) / area
        axes.text(x, y, text, transform=axes.transAxes, **style)
        (start,), (tip,) = leaders(at[group], np.array([[*corner, *(corner + size)]]))
        length = np.linalg.norm(tip - start)
        if length > _CLEAR_PT + _LEADER_PT:
            ends = np.stack([start + (tip - start) * (_MARKER_PT / 2 / length), tip]) / area
            axes.plot(*ends.T, transform=axes.transAxes, color=palette.warp(names[group[0]]), linewidth=0.9, zorder=2)


def _size_pt(figure: Any, text: str, weight: str) -> tuple[float, float]:
    from matplotlib.text import Text

    extent = Text(0, 0, text, weight=weight, parse_math=False, figure=figure).get_window_extent(
        figure.canvas.get_renderer()
    )
    return extent.width * 72 / figure.dpi, extent.height * 72 / figure.dpi


def _key(markers: Mapping[str, str], palette: Palette) -> list[Any]:
    from matplotlib.lines import Line2D

    style: Style = {
        "color": palette.ink,
        "markerfacecolor": "none",
        "markeredgewidth": 1.3,
        "linestyle": "none",
        "markersize": 6,
    }
    fills = [Line2D([], [], marker=marker, label=f"fill {fill}", **style) for fill, marker in markers.items()]
    return [*fills, Line2D([], [], color=palette.ink, linewidth=1.1, alpha=0.55, label="Pareto front (filled, bold)")]


def _key_style(palette: Palette) -> dict[str, Any]:
    return {
        "frameon": False, "labelcolor": palette.ink, "borderaxespad": 0.1, "handletextpad": 0.3,
        "columnspacing": 1.2, "borderpad": 0.2, "handlelength": 1.5,
    }  # fmt: skip
