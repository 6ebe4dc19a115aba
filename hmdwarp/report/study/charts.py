"""The charts of a study: ratings, differences, scores, places of trials."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..charts import Style, canvas, legend, mark, name_rows, svg_text
from ..style import PAGE, SERIES
from .results import condition_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Row = Mapping[str, Any]

_WIDTH_IN = 9.6
_BETTER, _WORSE, _ = SERIES  # their lines differ in dashes too
_MOST_PAIRS = 5  # more would need more columns than fit
_WRAP = 16  # letters of a condition's name in a line
_LINES: dict[int, tuple[str, Any]] = {1: (_BETTER, "solid"), -1: (_WORSE, (0, (4, 2))), 0: (PAGE.ink, (0, (1, 2)))}
_SHIFT_LABEL = "Hodges-Lehmann shift, exact 95 % or next level"


def ratings_chart(part: Row, comparisons: Sequence[Row], measure: Row) -> str:
    """Draw every rating of a part, up is better; lines join the compared ratings of one person."""
    names, pairs = _columns(part["conditions"], comparisons)
    by_name = {row["condition"]: row for row in part["conditions"]}
    values = [value for row in part["conditions"] for value in row["ratings"].values()]
    label = f"{measure['title'].lower()} (up is better)"
    with canvas((part["part"], measure["name"], names), (_WIDTH_IN, 3.6), y=label, grid="y") as axes:
        figure: Any = axes.get_figure()
        shifts = {name: _shifts(by_name[name]["ratings"]) for name in names}
        for x, row in pairs:
            _join(axes, x, row, by_name, shifts)
        for x, name in enumerate(names):
            _points(axes, x, by_name[name], shifts[name])
        axes.set_xticks(range(len(names)), [_label(by_name[name]) for name in names])
        axes.set_xlim(-0.6, len(names) - 0.4)
        axes.set_ylim(_limits(measure, values))
        lines = bool(pairs)
        key = [
            mark("one person", marker="o", linestyle="none", markerfacecolor="none"),
            mark("median (▸ mean)", linewidth=2.2),
        ]
        if lines:
            key.append(mark("rated better than the baseline", color=_BETTER, linewidth=1.2))
            key.append(mark("worse", color=_WORSE, linewidth=1.2, linestyle=(0, (4, 2))))
        legend(figure, key, loc="outside upper left", ncols=4)
        return svg_text(figure)


def forest_chart(rows: Sequence[Row], unit: str) -> str:
    """Draw each comparison's differences, their mean (BCa interval) and Hodges-Lehmann shift."""
    shown = [row for row in rows if row["n"]]
    content = [(row["part"], row["baseline"], row["condition"], row["mean"]) for row in shown]
    label = f"difference in {unit}:  rated worse than the baseline  ←  0  →  better"
    ends = [v for row in shown for v in [*row["differences"].values(), row["low"] or 0.0, row["high"] or 0.0]]
    reach = 1.08 * (max(map(abs, ends), default=0.0) or 1.0)
    with canvas(content, (_WIDTH_IN, 1.1 + 0.52 * max(len(shown), 2)), x=label, grid="x") as axes:
        figure: Any = axes.get_figure()
        axes.axvline(0, color=PAGE.ink, linewidth=1)
        for y, row in enumerate(shown):
            values = np.array(list(row["differences"].values()))
            dots: Style = {"color": PAGE.ink, "alpha": 0.45, "markersize": 3.2, "markeredgewidth": 0}
            axes.plot(values, y + 0.28 + _spread(len(values), 0.1), "o", **dots)
            bar: Style = {"solid_capstyle": "butt"}
            if row["low"] is not None:
                axes.plot([row["low"], row["high"]], [y - 0.1] * 2, color=_BETTER, linewidth=2.6, **bar)
            axes.plot(row["mean"], y - 0.1, "o", color=_BETTER, markersize=7)
            if row["shift_low"] is not None:
                axes.plot([row["shift_low"], row["shift_high"]], [y + 0.08] * 2, color=_WORSE, linewidth=1.4, **bar)
            axes.plot(row["shift"], y + 0.08, "D", color=_WORSE, markersize=4.5)
        name_rows(axes, [_comparison_label(row) for row in shown], above=0.7)
        axes.set_xlim(-reach, reach)
        key = [
            mark("mean, BCa 95 %", color=_BETTER, marker="o", markersize=7, linewidth=2.6),
            mark(_SHIFT_LABEL, color=_WORSE, marker="D", markersize=4.5, linewidth=1.4),
            mark("one person", alpha=0.45, marker="o", markersize=3.2, linestyle="none"),
        ]
        legend(figure, key, loc="outside upper left", ncols=3)
        return svg_text(figure)


def score_chart(part: Row) -> str:
    """Draw the scores of conditions from paired comparisons, the best on top."""
    rows = sorted(part["conditions"], key=lambda row: row["jod"])
    zero = "0 is the reference" if any(row["reference"] for row in rows) else "0 is the mean"
    label = f"JOD, with 95 % intervals; 1 more is preferred in 75 % of choices; {zero}"
    content = (part["part"], "scores", [(row["condition"], row["jod"]) for row in rows])
    with canvas(content, (_WIDTH_IN, 0.9 + 0.42 * max(len(rows), 2)), x=label, grid="x") as axes:
        axes.axvline(0, color=PAGE.ink, linewidth=1)
        for y, row in enumerate(rows):
            if row["low"] is not None:
                axes.plot([row["low"], row["high"]], [y, y], color=_BETTER, linewidth=2.5, solid_capstyle="butt")
            axes.plot(row["jod"], y, "o", color=_BETTER, markersize=8)
        axes.set_yticks(range(len(rows)), [_wrapped(condition_text(row)) for row in rows])
        axes.set_ylim(-0.6, len(rows) - 0.4)
        return svg_text(axes.get_figure())


def place_chart(part: Row, measure: Row) -> str:
    """Draw each rating, less its participant's and condition's mean, against its trial's place."""
    places = np.array([place["place"] for place in part["places"]])
    rest = np.array([place["rest"] for place in part["places"]])
    labels: Style = {"x": "place of the trial in the session", "y": f"{measure['unit']} (up is better)"}
    with canvas((part["part"], "places", rest.tolist()), (5.0, 2.4), **labels) as axes:
        axes.axhline(0, color=PAGE.ink, linewidth=1)
        dots: Style = {"color": _BETTER, "alpha": 0.35, "markersize": 3.5, "markeredgewidth": 0}
        axes.plot(places + _spread(len(places)), rest, "o", **dots)
        levels = np.unique(places)
        means = [rest[places == level].mean() for level in levels]
        axes.plot(levels, means, "D-", color=_WORSE, markersize=5, linewidth=1.2)
        axes.set_xticks(levels if len(levels) <= 20 else levels[:: len(levels) // 10])
        if measure["low_is_good"]:
            axes.invert_yaxis()
        return svg_text(axes.get_figure())


def _columns(conditions: Sequence[Row], comparisons: Sequence[Row]) -> tuple[list[str], list[tuple[int, Row]]]:
    """Return the names of the columns, and the place of each comparison's first one.

    The two conditions of a comparison stand side by side, a condition of two comparisons twice.
    With too many comparisons there are no lines.
    """
    names = [row["condition"] for row in conditions]
    if len(comparisons) > _MOST_PAIRS:
        return names, []
    columns = [name for row in comparisons for name in (row["baseline"], row["condition"])]
    return [*columns, *(name for name in names if name not in columns)], [
        (2 * k, row) for k, row in enumerate(comparisons)
    ]


def _shifts(ratings: Mapping[str, float]) -> dict[str, float]:
    """Return the sideways shift of each person's point, so that equal ratings lie side by side."""
    groups: dict[float, list[str]] = {}
    for who, value in ratings.items():
        groups.setdefault(value, []).append(who)
    step = min(0.07, 0.5 / max(map(len, groups.values()), default=1))
    return {who: step * (k - (len(people) - 1) / 2) for people in groups.values() for k, who in enumerate(people)}


def _join(axes: Axes, at: int, row: Row, by_name: Mapping[str, Row], shifts: Mapping[str, Mapping[str, float]]) -> None:
    a, b = row["baseline"], row["condition"]
    for who, difference in row["differences"].items():
        x = [at + shifts[a][who], at + 1 + shifts[b][who]]
        y = [by_name[a]["ratings"][who], by_name[b]["ratings"][who]]
        colour, dash = _LINES[(difference > 0) - (difference < 0)]
        axes.plot(x, y, color=colour, linestyle=dash, linewidth=0.9, alpha=0.6, zorder=1)


def _points(axes: Axes, x: int, row: Row, shifts: Mapping[str, float]) -> None:
    who, ink = list(row["ratings"]), PAGE.ink
    at = [x + shifts[name] for name in who]
    values = [row["ratings"][name] for name in who]
    axes.plot(at, values, "o", markersize=5, color=ink, markerfacecolor="none", zorder=3)
    if row["median"] is not None:
        axes.plot([x - 0.3, x + 0.3], [row["median"]] * 2, color=ink, linewidth=2.2, zorder=2, solid_capstyle="butt")
        axes.plot(x - 0.36, row["mean"], ">", markersize=6, color=ink, zorder=4)


def _label(row: Row) -> str:
    return _wrapped(condition_text(row)) + f"\nn = {row['n']}"


def _wrapped(name: str) -> str:
    # After a comma first: "forward + interpolate, 200 ms" keeps its 200 ms together. Then at a
    # space, or after the plus of a chain of fills.
    parts = (part.replace("+", "+\0 ").replace("+\0  ", "+ ") for part in name.split(", "))
    lines = (line for part in parts for line in textwrap.wrap(part, _WRAP, break_on_hyphens=False) or [part])
    return "\n".join(line.replace("\0 ", "").replace("\0", "") for line in lines)


def _limits(measure: Row, values: Sequence[float]) -> tuple[float, float]:
    """Return the limits of the axis of ratings, the better end on top."""
    ends = [end for end in (measure["least"], measure["most"]) if end is not None] if values else [0.0, 1.0]
    low, high = min([*values, *ends]), max([*values, *ends])
    margin = 0.05 * max(high - low, 1e-9)
    return (high + margin, low - margin) if measure["low_is_good"] else (low - margin, high + margin)


def _comparison_label(row: Row) -> str:
    first = f"{row['part']}: {row['condition']}" if row["part"] else row["condition"]
    return f"{first}\nover {row['baseline']}"


def _spread(count: int, width: float = 0.15) -> np.ndarray:
    """Return sideways places that look random and are always the same."""
    return width * (np.arange(count) * 0.618034 % 1 - 0.5)
