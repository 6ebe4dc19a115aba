"""Error against time, with the Pareto front: the chart to choose a method from."""

from __future__ import annotations

import io
import os
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ...metrics import PRIMARY, error_and_time, metrics
from ..files import write_bytes
from ..named_points import MARKER_PT, axes_in, draw_front, draw_names, scale_axis, scatter_figure
from ..style import PAGE, PAPER, Palette, Style, drawing, dress, markers_of, not_measured, svg_text, warp_of
from .rows import Case, Row, cases, measure_label

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_WIDTH_IN, _HEIGHT_IN = 9.6, 4.2
_WARPS_IN = 1.65  # width of the list of warps with their colours
_ABOVE: Style = {"xycoords": "axes fraction", "textcoords": "offset points"}
_KEY_IN = 0.32  # of a picture's height; enough for one line, or two of small text
_COLOURS_A_LINE = 7
_PNG_DPI = 200


def pareto_chart(case: Case, measure: str = PRIMARY, *, markers: Mapping[str, str] | None = None) -> str:
    """Draw one case as an <svg> element: mean error against median total time per eye.

    Time is logarithmic. The colour of a point says which warp it is, its mark which fill; warps of
    the front and baselines also have their names beside a point. Points of the front are filled,
    their names bold, and a line joins them: nothing lies below and left of it (above, for PSNR).
    Rows without a measurement are left out; a chart of nothing says so. markers: of the fills,
    where several charts are to share them.
    """
    markers = markers or markers_of(row["fill"] for row in case.rows)
    with drawing((case.label, measure, _content(case, measure))):
        figure = scatter_figure(_WIDTH_IN, _HEIGHT_IN)
        axes = axes_in(figure, (0.62, 0.5, _WIDTH_IN - _WARPS_IN, _HEIGHT_IN - 0.36))
        _draw(axes, case, measure, markers, PAGE)
        here = {fill: marker for fill, marker in markers.items() if fill in {row["fill"] for row in case.rows}}
        axes.legend(handles=_key(here, PAGE), loc="lower left", bbox_to_anchor=(0, 1), ncols=5, **_key_style(PAGE))
        figure.legend(
            handles=_colours([case], measure, PAGE), loc="upper left", ncols=1,
            bbox_to_anchor=(1 - (_WARPS_IN - 0.12) / _WIDTH_IN, 1), **_key_style(PAGE),
        )  # fmt: skip
        return svg_text(figure)


def pareto_plot_png(
    path: str | os.PathLike, rows: Iterable[Row], *, measure: str = PRIMARY, columns: int | None = None
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
        figure = scatter_figure(8, total)
        figure.patch.set_facecolor("white")
        if groups:
            style = _key_style(PAPER)
            top = (0.5 / 8, 1 - 0.06 / total)
            figure.legend(handles=_key(markers, PAPER), loc="upper left", bbox_to_anchor=top, ncols=5, **style)
            bottom = (0.5 / 8, foot / total)
            figure.legend(handles=colours, loc="upper left", bbox_to_anchor=bottom, ncols=_COLOURS_A_LINE, **style)
        for number, group in enumerate(groups):
            left, top_in = number % columns * width, foot + (lines - number // columns) * height
            axes = axes_in(figure, (left + 0.55, top_in - height + 0.45, left + width - 0.1, top_in - 0.3))
            axes.annotate(group.label, (0, 1), (0, 5), **_ABOVE, weight="bold", color=PAPER.ink, parse_math=False)
            _draw(axes, group, measure, markers, PAPER)
        buffer = io.BytesIO()
        figure.savefig(buffer, format="png", dpi=_PNG_DPI, metadata={"Software": None})
    return buffer.getvalue()


def pareto_text(case: Case, measure: str = PRIMARY) -> str:
    """Return the chart in words, for readers who cannot see it."""
    front = sorted(case.front(measure), key=_total)
    names = [f"{row['warp']} with fill {row['fill']} ({_total(row):.1f} ms)" for row in front]
    methods = ", ".join(names) or ("nothing was measured" if case.usable else "the bench's client can run none")
    return f"Error against time, {case.label}, {measure_label(measure)}. Pareto front, from quick to slow: {methods}."


def _total(row: Row) -> float:
    return row["time_ms"]["total"]["median"]


def _content(case: Case, measure: str) -> list[tuple[Any, ...]]:
    return [(row["warp"], row["fill"], *error_and_time(row, measure)) for row in case.rows]


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
    draw_names(axes, _names(rows, is_best, error, measure), np.stack([time, error], axis=1), is_best, line, palette)
    better = "better ↖" if metrics.get(measure).higher_is_better else "better ↙"
    axes.annotate(better, (1, 1), (0, 4), **_ABOVE, ha="right", color=palette.ink)


def _names(rows: Sequence[Row], is_best: np.ndarray, error: np.ndarray, measure: str) -> dict[str, list[int]]:
    """Return the points that each name belongs to, by index.

    Those of the front, or of a baseline that is not on it the best.
    """
    names: dict[str, list[int]] = {}
    for index, row in enumerate(rows):
        if is_best[index] or row.get("baseline"):
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


def _colours(groups: Sequence[Case], measure: str, palette: Palette) -> list[Any]:
    """Return each warp's name in its colour, the most accurate of the first case first."""
    from matplotlib.lines import Line2D

    names = dict.fromkeys(warp_of(row["warp"]) for group in groups for row in group.ordered(measure))
    style: Style = {"linestyle": "none", "marker": "s", "markersize": 6}
    return [Line2D([], [], color=palette.warp(name), label=name, **style) for name in names]


def _key_style(palette: Palette) -> dict[str, Any]:
    return {
        "frameon": False, "labelcolor": palette.ink, "borderaxespad": 0.1, "handletextpad": 0.3,
        "columnspacing": 1.2, "borderpad": 0.2, "handlelength": 1.5,
    }  # fmt: skip
