"""The charts of a study's page: every rating, paired differences, and the place of a trial."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..style import PAGE, SERIES, Style, drawing, dress, svg_text
from .tables import condition_text

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
    with drawing((part["part"], measure["name"], names)):
        figure, axes = _figure(_WIDTH_IN, 3.6)
        shifts = {name: _shifts(by_name[name]["ratings"]) for name in names}
        for x, row in pairs:
            _join(axes, x, row, by_name, shifts)
        for x, name in enumerate(names):
            _points(axes, x, by_name[name], shifts[name])
        axes.set_xticks(range(len(names)), [_label(by_name[name]) for name in names], parse_math=False)
        axes.set_xlim(-0.6, len(names) - 0.4)
        _rating_axis(axes, measure, [v for row in part["conditions"] for v in row["ratings"].values()])
        figure.legend(
            handles=_rating_key(bool(pairs)), loc="outside upper left", ncols=4, frameon=False, labelcolor=PAGE.ink
        )
        return svg_text(figure)


def forest_chart(rows: Sequence[Row], unit: str) -> str:
    """Draw each comparison's differences, their mean (BCa interval) and Hodges-Lehmann shift."""
    shown = [row for row in rows if row["n"]]
    with drawing([(row["part"], row["baseline"], row["condition"], row["mean"]) for row in shown]):
        figure, axes = _figure(_WIDTH_IN, 1.1 + 0.52 * max(len(shown), 2))
        dress(axes, PAGE, grid="x")
        axes.axvline(0, color=PAGE.ink, linewidth=1)
        for y, row in enumerate(shown):
            _forest_line(axes, y, row)
        axes.set_yticks(range(len(shown)), [_comparison_label(row) for row in shown], parse_math=False)
        axes.set_ylim(len(shown) - 0.4, -0.7)
        reach = max(
            (abs(v) for row in shown for v in [*row["differences"].values(), row["low"] or 0.0, row["high"] or 0.0]),
            default=1.0,
        )
        axes.set_xlim(-1.08 * max(reach, 1e-9), 1.08 * max(reach, 1e-9))
        axes.set_xlabel(f"difference in {unit}:  rated worse than the baseline  ←  0  →  better")
        figure.legend(handles=_forest_key(), loc="outside upper left", ncols=3, frameon=False, labelcolor=PAGE.ink)
        return svg_text(figure)


def score_chart(part: Row) -> str:
    """Draw the scores of conditions from paired comparisons, the best on top."""
    rows = sorted(part["conditions"], key=lambda row: row["jod"])
    with drawing((part["part"], "scores", [(row["condition"], row["jod"]) for row in rows])):
        figure, axes = _figure(_WIDTH_IN, 0.9 + 0.42 * max(len(rows), 2))
        dress(axes, PAGE, grid="x")
        axes.axvline(0, color=PAGE.ink, linewidth=1)
        for y, row in enumerate(rows):
            if row["low"] is not None:
                axes.plot([row["low"], row["high"]], [y, y], color=_BETTER, linewidth=2.5, solid_capstyle="butt")
            axes.plot(row["jod"], y, "o", color=_BETTER, markersize=8)
        axes.set_yticks(range(len(rows)), [_wrapped(condition_text(row)) for row in rows], parse_math=False)
        axes.set_ylim(-0.6, len(rows) - 0.4)
        zero = "0 is the reference" if any(row["reference"] for row in rows) else "0 is the mean"
        axes.set_xlabel(f"JOD, with 95 % intervals; 1 more is preferred in 75 % of choices; {zero}")
        return svg_text(figure)


def place_chart(part: Row, measure: Row) -> str:
    """Draw each rating, less its participant's and condition's mean, against its trial's place."""
    places = np.array([one["place"] for one in part["places"]])
    rest = np.array([one["rest"] for one in part["places"]])
    with drawing((part["part"], "places", rest.tolist())):
        figure, axes = _figure(5.0, 2.4)
        dress(axes, PAGE)
        axes.axhline(0, color=PAGE.ink, linewidth=1)
        axes.plot(
            places + _spread(len(places)), rest, "o", color=_BETTER, alpha=0.35, markersize=3.5, markeredgewidth=0
        )
        levels = np.unique(places)
        axes.plot(
            levels, [rest[places == level].mean() for level in levels], "D-", color=_WORSE, markersize=5, linewidth=1.2
        )
        axes.set_xticks(levels if len(levels) <= 20 else levels[:: len(levels) // 10])
        axes.set_xlabel("place of the trial in the session")
        axes.set_ylabel(f"{measure['unit']} (up is better)")
        if measure["low_is_good"]:
            axes.invert_yaxis()
        return svg_text(figure)


def scatter_chart(points: Sequence[Row], label: str, measure: Row) -> str:
    """Draw ratings against a measure. points: x, y."""
    x, y = np.array([one["x"] for one in points], float), np.array([one["y"] for one in points], float)
    with drawing((label, x.tolist(), y.tolist())):
        figure, axes = _figure(5.0, 2.6)
        dress(axes, PAGE)
        axes.plot(x, y, "o", color=_BETTER, alpha=0.55, markersize=4, markeredgewidth=0)
        axes.set_xlabel(label, parse_math=False)
        axes.set_ylabel(measure["title"].lower(), parse_math=False)
        if measure["low_is_good"]:
            axes.invert_yaxis()
        return svg_text(figure)


def _figure(width_in: float, height_in: float) -> tuple[Any, Axes]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width_in, height_in), layout="constrained")
    return figure, figure.add_subplot()


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
    import textwrap

    # After a comma first: "forward + interpolate, 200 ms" keeps its 200 ms together.
    return "\n".join(
        line for part in name.split(", ") for line in textwrap.wrap(part, _WRAP, break_on_hyphens=False) or [part]
    )


def _rating_axis(axes: Axes, measure: Row, values: Sequence[float]) -> None:
    dress(axes, PAGE, grid="y")
    ends = [end for end in (measure["least"], measure["most"]) if end is not None] if values else [0.0, 1.0]
    low, high = min([*values, *ends]), max([*values, *ends])
    margin = 0.05 * max(high - low, 1e-9)
    axes.set_ylim((high + margin, low - margin) if measure["low_is_good"] else (low - margin, high + margin))
    axes.set_ylabel(f"{measure['title'].lower()} (up is better)", parse_math=False)


def _rating_key(lines: bool) -> list[Any]:
    from matplotlib.lines import Line2D

    ink: Style = {"color": PAGE.ink}
    key = [
        Line2D([], [], marker="o", linestyle="none", markerfacecolor="none", label="one person", **ink),
        Line2D([], [], linewidth=2.2, label="median (▸ mean)", **ink),
    ]
    if lines:
        key += [
            Line2D([], [], color=_BETTER, linewidth=1.2, label="rated better than the baseline"),
            Line2D([], [], color=_WORSE, linewidth=1.2, linestyle=(0, (4, 2)), label="worse"),
        ]
    return key


def _forest_line(axes: Axes, y: int, row: Row) -> None:
    values = np.array(list(row["differences"].values()))
    axes.plot(
        values, y + 0.28 + _spread(len(values), 0.1), "o", color=PAGE.ink, alpha=0.45, markersize=3.2, markeredgewidth=0
    )
    if row["low"] is not None:
        axes.plot([row["low"], row["high"]], [y - 0.1] * 2, color=_BETTER, linewidth=2.6, solid_capstyle="butt")
    axes.plot(row["mean"], y - 0.1, "o", color=_BETTER, markersize=7)
    if row["shift_low"] is not None:
        axes.plot(
            [row["shift_low"], row["shift_high"]], [y + 0.08] * 2, color=_WORSE, linewidth=1.4, solid_capstyle="butt"
        )
    axes.plot(row["shift"], y + 0.08, "D", color=_WORSE, markersize=4.5)


def _comparison_label(row: Row) -> str:
    first = f"{row['part']}: {row['condition']}" if row["part"] else row["condition"]
    return f"{first}\nover {row['baseline']}"


def _forest_key() -> list[Any]:
    from matplotlib.lines import Line2D

    return [
        Line2D([], [], color=_BETTER, marker="o", markersize=7, linewidth=2.6, label="mean, BCa 95 %"),
        Line2D([], [], color=_WORSE, marker="D", markersize=4.5, linewidth=1.4, label=_SHIFT_LABEL),
        Line2D([], [], color=PAGE.ink, alpha=0.45, marker="o", markersize=3.2, linestyle="none", label="one person"),
    ]


def _spread(count: int, width: float = 0.15) -> np.ndarray:
    """Return sideways places that look random and are always the same."""
    return width * (np.arange(count) * 0.618034 % 1 - 0.5)
