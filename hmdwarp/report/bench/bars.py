"""Bar charts of a bench: the error by region, and each pass's time against its memory traffic."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from statistics import median
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np

from ...metrics import REGIONS
from ..style import HATCHES, PAGE, Style, drawing, dress, not_measured, svg_text
from .rows import Case, Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_LINE_IN = 0.21
_WIDTH_IN = 9.6
_REGION_MARKERS = ("s", "^", "o")
_KINDS = ("client_depth", "warp", "fill", "effects", "lens")


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
    return [((entry.get("share") or 0.0) * (entry.get("flip") or 0.0), entry.get("flip")) for entry in entries]


def regions_chart(case: Case) -> str:
    """Draw one case as an <svg> element: what each region adds to FLIP, and FLIP within each.

    The best row is on top.
    """
    measured = [(row, parts) for row in case.ordered() if (parts := region_parts(row))]
    with_fill = len({row["fill"] for row in case.rows}) > 1
    names = [row_name(row, with_fill) for row, _ in measured]
    height_in = 0.85 + _LINE_IN * max(len(measured), 2)
    with drawing((case.label, names, [parts for _, parts in measured])):
        from matplotlib.figure import Figure

        figure = Figure(figsize=(_WIDTH_IN, height_in), layout="constrained")
        left, right = figure.subplots(1, 2, sharey=True, width_ratios=(3, 2))
        for axes, label in ((left, "what each region adds to FLIP"), (right, "FLIP within each region")):
            dress(axes, PAGE, grid="x")
            axes.set_xlabel(label)
        if not measured:
            not_measured(left)
            return svg_text(figure)
        _stack(left, [[added for added, _ in parts] for _, parts in measured])
        _dots(right, [[flip for _, flip in parts] for _, parts in measured])
        left.set_yticks(range(len(names)), names, parse_math=False)
        left.set_ylim(len(names) - 0.4, -0.6)
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


def _region_key(figure: Any) -> None:
    from matplotlib.legend_handler import HandlerTuple
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles = []
    for colour, hatch, marker in zip(PAGE.regions, HATCHES, _REGION_MARKERS, strict=True):
        patch = Patch(facecolor=colour, edgecolor=PAGE.ink, hatch=hatch, linewidth=0.5)
        handles.append((patch, Line2D([], [], marker=marker, **_dot(colour))))
    figure.legend(
        handles, REGIONS, handler_map={tuple: HandlerTuple(ndivide=None, pad=0.6)}, handlelength=3.2,
        loc="outside upper left", ncols=len(REGIONS), frameon=False, labelcolor=PAGE.ink,
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
    height_in = 0.85 + _LINE_IN * max(len(passes), 2)
    with drawing([attrs.astuple(entry) for entry in passes]):
        from matplotlib.figure import Figure
        from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

        figure = Figure(figsize=(_WIDTH_IN, height_in), layout="constrained")
        axes = figure.add_subplot()
        dress(axes, PAGE, grid="x")
        axes.set_xlabel("time per eye in ms")
        shown = [entry for entry in passes if entry.bound_ms > 0 and entry.median_ms > 0]
        if not shown:
            not_measured(axes)
            return svg_text(figure)
        axes.set_xscale("log")
        for y, entry in enumerate(shown):
            _traffic_line(axes, y, entry)
        names = [entry.name if entry.kind == "warp" else entry.label for entry in shown]
        axes.set_yticks(range(len(shown)), names, parse_math=False)
        axes.set_ylim(len(shown) - 0.4, -0.6)
        low, high = axes.get_xlim()
        axes.set_xlim(low, max(high * 1.3, low * 4))
        axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axes.xaxis.set_minor_locator(NullLocator())
        axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        figure.legend(handles=_traffic_key(), loc="outside upper left", ncols=2, frameon=False, labelcolor=PAGE.ink)
        return svg_text(figure)


def _traffic_line(axes: Axes, y: int, entry: Traffic) -> None:
    colour = PAGE.warp(entry.name) if entry.kind == "warp" else PAGE.ink
    bound: Style = {"marker": "|", "markersize": 11, "markeredgewidth": 1.8, "color": PAGE.ink, "linestyle": "none"}
    axes.plot([entry.bound_ms, entry.median_ms], [y, y], color=colour, linewidth=1.6, zorder=2)
    axes.plot(entry.bound_ms, y, **bound, zorder=3)
    axes.plot(entry.median_ms, y, marker="o", markersize=6, color=colour, linestyle="none", zorder=4)
    text: Style = {"textcoords": "offset points", "va": "center", "color": PAGE.ink}
    axes.annotate(f"{entry.times_bound:.1f}×", (max(entry.median_ms, entry.bound_ms), y), (8, 0), **text)


def _traffic_key() -> list[Any]:
    from matplotlib.lines import Line2D

    style: Style = {"color": PAGE.ink, "linestyle": "none"}
    bound = Line2D([], [], marker="|", markersize=11, markeredgewidth=1.8, label="bound by memory traffic", **style)
    return [bound, Line2D([], [], marker="o", markersize=6, label="time taken", **style)]
