"""Error against displacement of the head since the late frame: a chart per axis, lines per warp."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...metrics import PRIMARY
from ..label_places import spread
from ..style import PAGE, dashes_of, drawing, dress, not_measured, svg_text
from .rows import measure_label

if TYPE_CHECKING:
    from matplotlib.axes import Axes

GridRow = Mapping[str, Any]

AXES = ("x", "y", "z", "yaw", "pitch", "roll")
_MEANINGS = {
    "x": "to the right", "y": "up", "z": "backwards",
    "yaw": "turned to the left", "pitch": "looking up", "roll": "tilted to the left",
}  # fmt: skip
_LINE_PT = 10.5  # between two names
_PLOT_IN, _BELOW_IN, _ABOVE_IN = 3.3, 0.5, 0.12
_CHAR_PT = 5.6  # width of DejaVu Sans at 9 points, on the safe side


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
    with drawing((axis, measure, [(warp, points.tolist()) for warp, points in lines.items()])):
        from matplotlib.figure import Figure

        names_in = max(map(len, lines), default=0) * _CHAR_PT / 72 + 0.45
        width_in = 0.6 + _PLOT_IN + names_in
        figure = Figure(figsize=(width_in, height_in))
        axes = figure.add_axes(
            (0.6 / width_in, _BELOW_IN / height_in, _PLOT_IN / width_in, 1 - (_BELOW_IN + _ABOVE_IN) / height_in)
        )
        dress(axes, PAGE)
        axes.set_xlabel(f"offset in {'degrees' if is_turn(axis) else 'metres'}")
        axes.set_ylabel(measure_label(measure))
        if lines:
            axes.set_ylim(_limits(grid, axis, measure))
            _draw(axes, lines, dashes_of(dict.fromkeys(row["warp"] for row in grid)), height_in)
        else:
            not_measured(axes)
        return svg_text(figure)


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


def _draw(axes: Axes, lines: Mapping[str, NDArray[np.float64]], dashes: Mapping[str, Any], height_in: float) -> None:
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
            va="center", ha="left", color=PAGE.ink, parse_math=False, annotation_clip=False,
            arrowprops={**tie, "shrinkA": 1, "shrinkB": 0},
        )  # fmt: skip
