"""Charts as SVG that takes its colours and its font from the page around it, so that one chart serves light and dark."""

from __future__ import annotations

import hashlib
import io
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Colours that Matplotlib writes and svg_text() replaces by the page's variables of the same order.
INK, GRID = "#010101", "#020202"
SERIES = ("#030303", "#040404")
_VARIABLES = {INK: "--chart-ink", GRID: "--chart-grid", SERIES[0]: "--series-1", SERIES[1]: "--series-2"}
_DASHES = ("solid", (0, (4, 2)))  # lines differ in more than colour

_MOST_POINTS = 400  # about one per device pixel; a run of hours makes a page no larger than one of minutes
_FEW_POINTS = 12  # fewer are drawn as dots too, a line alone could be missed


@attrs.frozen(eq=False)
class Series:
    """One line of a chart: `value` at `time_s`, both 1-D and of one length, in order of time. NaN leaves a gap."""

    label: str
    time_s: NDArray[np.float64]
    value: NDArray[np.float64]

    @classmethod
    def of(cls, label: str, rows: Iterable[Mapping[str, Any]], column: str, scale: float = 1.0) -> Series:
        """A column of frames.csv's rows against time; rows without a value are left out."""
        pairs = [(row["time_s"], row[column] * scale) for row in rows if row.get(column) is not None]
        points = np.array(sorted(pairs), dtype=np.float64).reshape(-1, 2)
        return cls(label, points[:, 0], points[:, 1])


@attrs.frozen(eq=False)
class Band:
    """A series in bins of time: the mean of each bin that holds anything, and its least and largest value."""

    time_s: NDArray[np.float64]
    mean: NDArray[np.float64]
    low: NDArray[np.float64]
    high: NDArray[np.float64]


def binned(series: Series, bins: int = _MOST_POINTS) -> Band:
    """Values of one instant (the two eyes) become one point; more than `bins` instants are pooled into that many bins."""
    there = np.isfinite(series.value)
    time_s, value = series.time_s[there], series.value[there]
    instants, index = np.unique(time_s, return_inverse=True)
    if len(instants) > bins:
        edges = np.linspace(instants[0], instants[-1], bins + 1)
        index = np.clip(np.searchsorted(edges, time_s, side="right") - 1, 0, bins - 1)
        _, index = np.unique(index, return_inverse=True)
    count = index.max() + 1 if len(index) else 0
    amount = np.bincount(index, minlength=count)
    low, high = np.full(count, np.inf), np.full(count, -np.inf)
    np.minimum.at(low, index, value)
    np.maximum.at(high, index, value)
    mean = np.bincount(index, value, minlength=count) / amount
    return Band(np.bincount(index, time_s, minlength=count) / amount, mean, low, high)


def time_series(
    series: Sequence[Series], unit: str, *, from_zero: bool = True, width_in: float = 5.0, height_in: float = 2.2
) -> str:
    """Lines over time as one <svg> element; a pale band spans what the two eyes, or the pooled frames, range over.

    unit: of the vertical axis, "" for a plain number. Empty series are left out; a chart of nothing says so.
    The same data give the same text. Colours: the CSS variables --chart-ink, --chart-grid, --series-1, --series-2.
    """
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    # The salt makes the ids of this chart's clip paths its own on a page with several.
    salt = hashlib.sha256(b"".join(s.label.encode() + s.value.tobytes() for s in series)).hexdigest()
    with rc_context({"svg.fonttype": "none", "svg.hashsalt": salt, "font.size": 9, "font.sans-serif": ["DejaVu Sans"]}):
        figure = Figure(figsize=(width_in, height_in), layout="constrained")
        axes = figure.add_subplot()
        drawn = [_draw(axes, number, line) for number, line in enumerate(series)]
        _dress(axes, unit, from_zero)
        if not any(drawn):
            axes.text(0.5, 0.5, "not measured", transform=axes.transAxes, ha="center", va="center", color=INK)
        elif len(drawn) > 1:
            axes.legend(
                loc="lower left",
                bbox_to_anchor=(0, 1),
                ncols=2,
                frameon=False,
                labelcolor=INK,
                borderaxespad=0,
                handlelength=2.5,
            )
        return svg_text(figure)


def _draw(axes: Axes, number: int, series: Series) -> bool:
    band = binned(series)
    if not len(band.mean):
        return False
    colour = SERIES[number]
    marker = "o" if len(band.mean) <= _FEW_POINTS else ""
    if (band.high > band.low).any():
        axes.fill_between(band.time_s, band.low, band.high, color=colour, alpha=0.2, linewidth=0)
    style = {"linestyle": _DASHES[number], "linewidth": 1.3, "marker": marker, "markersize": 3}
    axes.plot(band.time_s, band.mean, color=colour, label=series.label, **style)
    return True


def _dress(axes: Axes, unit: str, from_zero: bool) -> None:
    axes.patch.set_visible(False)
    axes.figure.patch.set_visible(False)
    axes.grid(True, color=GRID, linewidth=0.6)
    axes.set_axisbelow(True)
    for side, spine in axes.spines.items():
        spine.set_visible(side == "bottom")
        spine.set_color(INK)
    axes.tick_params(colors=INK, length=0)
    axes.set_xlabel("time in s", color=INK)
    axes.set_ylabel(unit, color=INK)
    axes.margins(x=0.01)
    if from_zero:
        axes.set_ylim(bottom=0)
        axes.set_ylim(top=max(axes.get_ylim()[1], 1e-9))


def svg_text(figure: Any) -> str:
    """A figure as an <svg> element to stand in a page: no XML prologue, colours as CSS variables, no date, width left to the page."""
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
    text = buffer.getvalue()
    text = text[text.index("<svg") :]
    for colour, variable in _VARIABLES.items():
        text = text.replace(colour, f"var({variable})")
    # Matplotlib's <style> would reach the whole page, and its group ids are the same in every chart.
    text = re.sub(r"<style.*?</style>", "", text, flags=re.DOTALL)
    text = re.sub(r'<g id="[^"]*"', "<g", text)
    head, rest = text.split(">", 1)
    parts = [part for part in head.split('" ') if not part.startswith(("width=", "height="))]
    return '" '.join(parts) + ">" + rest
