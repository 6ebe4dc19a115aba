"""Where the error lies, and how far each pass is above what its memory traffic alone would take."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from statistics import median
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np

from ..metrics import REGIONS
from .bench_cases import Case, Row
from .bench_style import HATCHES, PAGE, drawing, dress, svg_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_LINE_IN = 0.21
_WIDTH_IN = 9.6
_REGION_MARKERS = ("s", "^", "o")
_KINDS = ("client_depth", "warp", "fill", "effects", "lens")


def row_name(row: Row, with_fill: bool = True) -> str:
    """A row in one line: its warp, and its fill where there are several."""
    return f"{row['warp']} + {row['fill']}" if with_fill and row["fill"] != "none" else row["warp"]


def region_parts(row: Row) -> list[tuple[float, float | None]] | None:
    """Of holes, edges and elsewhere what they add to FLIP (share of pixels x FLIP there), and FLIP there; None if not measured."""
    regions = row.get("regions") or {}
    if not all(name in regions for name in REGIONS):
        return None
    entries = [regions[name] for name in REGIONS]
    return [((entry.get("share") or 0.0) * (entry.get("flip") or 0.0), entry.get("flip")) for entry in entries]


def regions_chart(case: Case) -> str:
    """One case as an <svg> element: bars of what each region adds to FLIP, beside it FLIP within each region; the best row on top."""
    found = [(row, parts) for row in case.ordered() if (parts := region_parts(row))]
    with_fill = len({row["fill"] for row in case.rows}) > 1
    names = [row_name(row, with_fill) for row, _ in found]
    height_in = 0.85 + _LINE_IN * max(len(found), 2)
    with drawing((case.label, names, [parts for _, parts in found])):
        from matplotlib.figure import Figure

        figure = Figure(figsize=(_WIDTH_IN, height_in), layout="constrained")
        left, right = figure.subplots(1, 2, sharey=True, width_ratios=(3, 2))
        for axes, label in ((left, "what each region adds to FLIP"), (right, "FLIP within each region")):
            dress(axes, PAGE, grid="x")
            axes.set_xlabel(label)
        if not found:
            left.text(0.5, 0.5, "not measured", transform=left.transAxes, ha="center", va="center", color=PAGE.ink)
            return svg_text(figure)
        _stack(left, [[added for added, _ in parts] for _, parts in found])
        _dots(right, [[flip for _, flip in parts] for _, parts in found])
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
        points = [(values[number], y) for y, values in enumerate(flips) if values[number] is not None]
        style = {
            "markersize": 6,
            "markeredgecolor": PAGE.ink,
            "markeredgewidth": 0.7,
            "linestyle": "none",
            "color": PAGE.regions[number],
        }
        axes.plot([x for x, _ in points], [y for _, y in points], marker=marker, **style)


def _region_key(figure: Any) -> None:
    from matplotlib.legend_handler import HandlerTuple
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles = []
    for colour, hatch, marker in zip(PAGE.regions, HATCHES, _REGION_MARKERS, strict=True):
        dot = {"color": colour, "markeredgecolor": PAGE.ink, "markeredgewidth": 0.7, "linestyle": "none"}
        handles.append(
            (
                Patch(facecolor=colour, edgecolor=PAGE.ink, hatch=hatch, linewidth=0.5),
                Line2D([], [], marker=marker, **dot),
            )
        )
    figure.legend(
        handles, REGIONS, handler_map={tuple: HandlerTuple(ndivide=None, pad=0.6)}, handlelength=3.2,
        loc="outside upper left", ncols=len(REGIONS), frameon=False, labelcolor=PAGE.ink,
    )  # fmt: skip


@attrs.frozen
class Traffic:
    """One pass at one size: what it moves in bytes, the time that alone would take, and the time it does take, in ms per eye."""

    kind: str
    name: str
    size: str
    bytes: float
    bound_ms: float
    median_ms: float

    @property
    def label(self) -> str:
        """'warp forward', 'fill none'; a pass of which there is one kind only has that name."""
        return self.kind if self.kind == self.name else f"{self.kind} {self.name}"

    @property
    def times_bound(self) -> float:
        """How many times the bound the pass takes; infinite for a pass that moves nothing."""
        return self.median_ms / self.bound_ms if self.bound_ms > 0 else float("inf")


def traffic(rows: Iterable[Row]) -> list[Traffic]:
    """Each pass once for each size, medians over the rows that hold it: warps, fills, lenses, each from quick to slow."""
    found: dict[tuple[str, str, str], list[Any]] = {}
    for row in rows:
        for entry in row.get("passes") or ():
            if entry.get("median_ms") is not None and entry.get("bound_ms") is not None:
                kind = entry["name"]
                size = "x".join(map(str, row["size"]))
                found.setdefault((kind, str(row.get(kind, kind)), size), []).append(entry)
    out = [
        Traffic(*key, *(float(median(entry[name] for entry in entries)) for name in ("bytes", "bound_ms", "median_ms")))
        for key, entries in found.items()
    ]
    order = {kind: number for number, kind in enumerate(_KINDS)}
    return sorted(out, key=lambda t: (t.size, order.get(t.kind, len(order)), t.median_ms))


def traffic_chart(passes: Sequence[Traffic]) -> str:
    """An <svg> element: of each pass the bound (a bar across), the time (a dot) and how many times the bound it is; time logarithmic."""
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
            axes.text(0.5, 0.5, "not measured", transform=axes.transAxes, ha="center", va="center", color=PAGE.ink)
            return svg_text(figure)
        axes.set_xscale("log")
        for y, entry in enumerate(shown):
            colour = PAGE.warp(entry.name) if entry.kind == "warp" else PAGE.ink
            axes.plot([entry.bound_ms, entry.median_ms], [y, y], color=colour, linewidth=1.6, zorder=2)
            axes.plot(
                entry.bound_ms,
                y,
                marker="|",
                markersize=11,
                markeredgewidth=1.8,
                color=PAGE.ink,
                linestyle="none",
                zorder=3,
            )
            axes.plot(entry.median_ms, y, marker="o", markersize=6, color=colour, linestyle="none", zorder=4)
            text = {"textcoords": "offset points", "va": "center", "color": PAGE.ink}
            axes.annotate(f"{entry.times_bound:.1f}×", (max(entry.median_ms, entry.bound_ms), y), (8, 0), **text)
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


def _traffic_key() -> list[Any]:
    from matplotlib.lines import Line2D

    style = {"color": PAGE.ink, "linestyle": "none"}
    bound = Line2D([], [], marker="|", markersize=11, markeredgewidth=1.8, label="bound by memory traffic", **style)
    return [bound, Line2D([], [], marker="o", markersize=6, label="time taken", **style)]
