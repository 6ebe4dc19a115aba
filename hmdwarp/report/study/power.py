"""Power against the number of people: a line per comparison, with the simulation's uncertainty."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import attrs

from ..style import PAPER

QUIET = "#8a939c"
# Okabe and Ito's colours without yellow and black: distinct with every kind of colour vision.
# Dashes and markers differ as well.
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00")
MARKERS, DASHES = "osD^vP", ("solid", (0, (5, 2)), (0, (2, 1.5)))


@attrs.frozen
class PowerLine:
    """The power of one comparison, 0..1, one value for each n."""

    name: str
    power: Sequence[float]
    low: Sequence[float]
    high: Sequence[float]
    # Without what a scale's answers lose of what is felt.
    unlimited: Sequence[float]


def power_chart(
    path: Path,
    ns: Sequence[int],
    lines: Sequence[PowerLine],
    target: float,
    title: str,
    unlimited: str = "without ends and steps of the scale",
) -> None:
    """Write the chart as a PNG; target: the power to reach. unlimited: what those values are."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.2, 4.4), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    axes.axhline(target, color=QUIET, linewidth=1.2, label=f"{target:.0%}, the target")
    for number, line in enumerate(lines):
        colour = COLOURS[number % len(COLOURS)]
        style = DASHES[number // len(COLOURS) % len(DASHES)]
        axes.fill_between(ns, line.low, line.high, color=colour, alpha=0.15, linewidth=0)
        marker = MARKERS[number % len(MARKERS)]
        axes.plot(ns, line.power, color=colour, linestyle=style, marker=marker, markersize=5, label=line.name)
        axes.plot(ns, line.unlimited, color=colour, linestyle=(0, (1, 2)), linewidth=1)
    axes.plot([], [], color=PAPER.ink, linestyle=(0, (1, 2)), linewidth=1, label=unlimited)
    axes.set(xlabel="people who begin", ylabel="power (after Holm)", ylim=(-0.02, 1.02), title=title)
    axes.set_xticks(ns)
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:.0%}")
    axes.grid(color=PAPER.grid, linewidth=0.8)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5))
    figure.savefig(path, format="png", dpi=150)
