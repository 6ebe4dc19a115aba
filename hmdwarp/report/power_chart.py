"""Power against the number of people: a line for each comparison, with what the simulation leaves open."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import attrs

INK, QUIET = "#30373f", "#8a939c"
# Okabe and Ito's colours but for yellow and black: told apart with every kind of colour vision. Dashes and markers differ as well.
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00")
MARKERS, DASHES = "osD^vP", ("solid", (0, (5, 2)), (0, (2, 1.5)))


@attrs.frozen
class PowerLine:
    """power, low, high: 0..1, one for each n. unlimited: power without the scale's ends and steps."""

    name: str
    power: Sequence[float]
    low: Sequence[float]
    high: Sequence[float]
    unlimited: Sequence[float]


def power_chart(path: Path, ns: Sequence[int], lines: Sequence[PowerLine], wanted: float, title: str) -> None:
    """Write a PNG."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.2, 4.4), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    axes.axhline(wanted, color=QUIET, linewidth=1.2, label=f"{wanted:.0%}, as wanted")
    for number, line in enumerate(lines):
        colour = COLOURS[number % len(COLOURS)]
        style = DASHES[number // len(COLOURS) % len(DASHES)]
        axes.fill_between(ns, line.low, line.high, color=colour, alpha=0.15, linewidth=0)
        axes.plot(
            ns,
            line.power,
            color=colour,
            linestyle=style,
            marker=MARKERS[number % len(MARKERS)],
            markersize=5,
            label=line.name,
        )
        axes.plot(ns, line.unlimited, color=colour, linestyle=(0, (1, 2)), linewidth=1)
    axes.plot([], [], color=INK, linestyle=(0, (1, 2)), linewidth=1, label="without ends and steps of the scale")
    axes.set(xlabel="people who begin", ylabel="power (found, after Holm)", ylim=(-0.02, 1.02), title=title)
    axes.set_xticks(ns)
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:.0%}")
    axes.grid(color="#e2e6ea", linewidth=0.8)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5))
    figure.savefig(path, format="png", dpi=150)
