"""Scatter charts whose points have names: error against what it costs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from .label_places import leaders, place_labels
from .style import Palette, Style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MARKER_PT = 6.5
_CLEAR_PT = 4.5  # half the side of the square around a marker that no label covers
_LEADER_PT = 2.5  # a label nearer than that to its marker needs no line to it
_NOTHING = 1e-3  # a microsecond, a kbit/s, an error that rounds to 0.000


def scatter_figure(width_in: float, height_in: float) -> Figure:
    """Return an empty figure of that size."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width_in, height_in))
    FigureCanvasAgg(figure)
    return figure


def axes_in(figure: Figure, box: tuple[float, float, float, float]) -> Axes:
    """Add axes at a fixed place (left, bottom, right, top in inches): placing labels needs it."""
    width, height = figure.get_size_inches()
    left, bottom, right, top = box
    return figure.add_axes((left / width, bottom / height, (right - left) / width, (top - bottom) / height))


def scale_axis(axis: Any, values: np.ndarray, *, logarithmic: bool) -> np.ndarray:
    """Set limits with a margin around the values, and plain numbers at the ticks.

    Returns where the values are drawn. A logarithmic axis has no zero: what is below _NOTHING is
    drawn a step before the least of the others, at a tick that says 0.
    """
    from matplotlib.ticker import FixedLocator, FuncFormatter, LogLocator, MaxNLocator, NullLocator

    limits = axis.axes.set_xlim if axis.axis_name == "x" else axis.axes.set_ylim
    if not logarithmic:
        low, high = values.min(), values.max()
        margin = max(0.08 * (high - low), 0.5)
        limits(low - margin, high + margin)
        axis.set_major_locator(MaxNLocator(6))
        return values
    some = values[values >= _NOTHING]
    least, most = (some.min(), some.max()) if len(some) else (_NOTHING, _NOTHING)
    zero = least / 2
    drawn = np.where(values < _NOTHING, zero, values)
    low, high = np.log10([drawn.min(), most])
    # At least a factor of four, so that two ticks are in it.
    margin = max(0.06 * (high - low), (np.log10(4) - (high - low)) / 2)
    scale = axis.axes.set_xscale if axis.axis_name == "x" else axis.axes.set_yscale
    scale("log")
    limits(10 ** (low - margin), 10 ** (high + margin))
    axis.set_major_locator(LogLocator(subs=(1, 2, 5) if high - low > 1 else (1, 1.5, 2, 3, 5, 7)))
    has_zero = len(some) < len(values)
    if has_zero:
        axis.set_major_locator(FixedLocator([zero, *(tick for tick in axis.get_majorticklocs() if tick >= least)]))
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FuncFormatter(lambda value, _: "0" if has_zero and value < least else f"{value:g}"))
    return drawn


def draw_names(
    axes: Axes, names: Mapping[str, list[int]], points: np.ndarray, is_best: np.ndarray, line: np.ndarray,
    palette: Palette,
) -> None:  # fmt: skip
    """Write each name beside one of its points."""
    to_points, box = 72 / axes.figure.dpi, axes.get_window_extent()
    area = (box.width * to_points, box.height * to_points)
    at = (axes.transData.transform(points) - (box.x0, box.y0)) * to_points
    bends = (axes.transData.transform(line) - (box.x0, box.y0)) * to_points
    groups = list(names.values())
    weights = ["bold" if is_best[group].any() else "normal" for group in groups]
    sizes = np.array([_size_pt(axes.figure, *pair) for pair in zip(names, weights, strict=True)])
    corners = place_labels([at[group] for group in groups], sizes, area, clearance=_CLEAR_PT, line=bends, others=at)
    for text, group, weight, corner, size in zip(names, groups, weights, corners, sizes, strict=True):
        style: Style = {
            "weight": weight,
            "ha": "center",
            "va": "center",
            "color": palette.ink,
            "parse_math": False,
            "linespacing": 1.0,
            "zorder": 6,
        }
        x, y = (corner + size / 2) / area
        axes.text(x, y, text, transform=axes.transAxes, **style)
        (start,), (tip,) = leaders(at[group], np.array([[*corner, *(corner + size)]]))
        length = np.linalg.norm(tip - start)
        if length > _CLEAR_PT + _LEADER_PT:
            ends = np.stack([start + (tip - start) * (MARKER_PT / 2 / length), tip]) / area
            axes.plot(*ends.T, transform=axes.transAxes, color=palette.ink, linewidth=0.7, zorder=2)


def _size_pt(figure: Any, text: str, weight: str) -> tuple[float, float]:
    from matplotlib.text import Text

    extent = Text(0, 0, text, weight=weight, parse_math=False, linespacing=1.0, figure=figure).get_window_extent(
        figure.canvas.get_renderer()
    )
    return extent.width * 72 / figure.dpi, extent.height * 72 / figure.dpi


def draw_front(axes: Axes, cost: np.ndarray, error: np.ndarray, palette: Palette, *, higher: bool) -> np.ndarray:
    """Draw the staircase that bounds these points; return it as (m, 2) in data coordinates.

    Without points there is none.
    higher: whether a higher error measure is better.
    """
    if not len(cost):
        return np.zeros((0, 2))
    order = np.argsort(cost, kind="stable")
    cost, error = cost[order], error[order]
    worst = axes.get_ylim()[0 if higher else 1]
    x = np.concatenate([[cost[0]], cost, [axes.get_xlim()[1]]])
    y = np.concatenate([[worst], error, error[-1:]])
    axes.plot(x, y, drawstyle="steps-post", color=palette.ink, linewidth=1.1, alpha=0.55, zorder=2)
    return np.stack([np.repeat(x, 2)[1:], np.repeat(y, 2)[:-1]], axis=1)
