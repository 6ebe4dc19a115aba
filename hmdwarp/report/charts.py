"""Charts over time as SVG."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np
from numpy.typing import NDArray

from .style import PAGE, SERIES, Style, drawing, dress, not_measured, svg_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_DASHES = ("solid", (0, (4, 2)), (0, (1, 1.5)))  # lines differ in more than colour
_MOST_POINTS = 400  # about one per device pixel; a run of hours makes a page no larger than one of minutes
_FEW_POINTS = 12  # fewer are drawn as dots too: a line alone could be missed


@attrs.frozen(eq=False)
class Series:
    """One line of a chart."""

    label: str
    # 1-D and of one length, in order of time; NaN leaves a gap.
    time_s: NDArray[np.float64]
    value: NDArray[np.float64]
    # Instants that a tick marks at the foot of the chart, in order.
    ticks_s: NDArray[np.float64] = attrs.field(factory=lambda: np.empty(0))

    @classmethod
    def of(
        cls,
        label: str,
        rows: Iterable[Mapping[str, Any]],
        column: str,
        scale: float = 1.0,
        ticks_s: Sequence[float] = (),
    ) -> Series:
        """Take a column of frames.csv's rows against time; rows without a value are left out."""
        pairs = [(row["time_s"], row[column] * scale) for row in rows if row.get(column) is not None]
        points = np.array(sorted(pairs), dtype=np.float64).reshape(-1, 2)
        return cls(label, points[:, 0], points[:, 1], np.array(ticks_s, dtype=np.float64))


@attrs.frozen(eq=False)
class Band:
    """A series in bins of time, without empty bins: mean, least and largest value of each."""

    time_s: NDArray[np.float64]
    mean: NDArray[np.float64]
    low: NDArray[np.float64]
    high: NDArray[np.float64]


def binned(series: Series, bins: int = _MOST_POINTS) -> Band:
    """Make one point of the values of one instant (the two eyes); pool the instants into `bins`."""
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


def time_series(series: Sequence[Series], unit: str, *, from_zero: bool = True) -> str:
    """Draw at most three lines over time as one <svg> element.

    A pale band spans the values of the two eyes, or of the pooled frames. Empty series are left
    out, ticks included; a chart of nothing says so. The same data give the same text.
    unit: of the vertical axis, "" for a plain number.
    """
    with drawing([(line.label, line.value.tobytes(), line.ticks_s.tobytes()) for line in series]):
        from matplotlib.figure import Figure

        figure = Figure(figsize=(5.0, 2.2), layout="constrained")
        axes = figure.add_subplot()
        drawn = [_draw(axes, number, line) for number, line in enumerate(series)]
        dress(axes)
        axes.set_xlabel("time in s")
        axes.set_ylabel(unit)
        axes.margins(x=0.01)
        if from_zero:
            axes.set_ylim(bottom=0)
            axes.set_ylim(top=max(axes.get_ylim()[1], 1e-9))
        if not any(drawn):
            not_measured(axes)
        elif len(drawn) > 1:
            axes.legend(
                loc="lower left", bbox_to_anchor=(0, 1), ncols=2, frameon=False, labelcolor=PAGE.ink, borderaxespad=0,
                handlelength=2.5,
            )  # fmt: skip
        return svg_text(figure)


def _draw(axes: Axes, number: int, series: Series) -> bool:
    band = binned(series)
    if not len(band.mean):
        return False
    colour = SERIES[number]
    marker = "o" if len(band.mean) <= _FEW_POINTS else ""
    if (band.high > band.low).any():
        axes.fill_between(band.time_s, band.low, band.high, color=colour, alpha=0.2, linewidth=0)
    style: Style = {"linestyle": _DASHES[number], "linewidth": 1.3, "marker": marker, "markersize": 3}
    axes.plot(band.time_s, band.mean, color=colour, label=series.label, **style)
    if len(series.ticks_s):
        ticks = binned(Series("", series.ticks_s, series.ticks_s)).time_s
        style = {"linestyle": "", "marker": "|", "markersize": 5, "transform": axes.get_xaxis_transform()}
        axes.plot(ticks, np.full(len(ticks), 0.03 + 0.06 * number), color=colour, **style)
    return True
