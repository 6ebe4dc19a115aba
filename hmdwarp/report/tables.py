"""The figures of a run in the order, units and rounding in which people read them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import attrs

from ..metrics import STAGES, Figure, metrics, metrics_in_order

if TYPE_CHECKING:
    from rich.table import Table


Summary = Mapping[str, Any]


QUALITY_FIGURES = tuple(metric.figure for metric in metrics_in_order())
TIME_FIGURES = tuple(Figure(stage, stage.capitalize(), "ms", 2) for stage in STAGES)
_CONTESTS = frozenset(metric.name for metric in metrics_in_order() if metric.is_contest)


@attrs.frozen
class Row:
    """One line of the comparison."""

    figure: Figure
    # (main figure, tail) of each run, as text.
    cells: tuple[tuple[str, str], ...]
    # Index of the better run, if any.
    best: int | None


def comparison_rows(summary: Summary, baseline: Summary | None) -> list[Row]:
    """Return the rows of quality, then of time per eye; two cells each if there is a baseline.

    The better of two means is marked if they differ after rounding. Time and holes are no contest:
    a warp that does nothing is quick and leaves nothing empty.
    """
    summaries = [summary] if baseline is None else [summary, baseline]
    rows = [_row(figure, [s["quality"][figure.name] for s in summaries], "mean") for figure in QUALITY_FIGURES]
    return rows + [_row(figure, [s["time_ms"][figure.name] for s in summaries], "median") for figure in TIME_FIGURES]


def _row(figure: Figure, entries: list[Mapping[str, float | None]], main: str) -> Row:
    cells = tuple((figure.text(e[main]), figure.text(e["p95"])) for e in entries)
    if figure.name not in _CONTESTS or len(entries) < 2 or cells[0][0] == cells[1][0]:
        return Row(figure, cells, None)
    first, second = (entry[main] for entry in entries)
    if first is None or second is None:
        return Row(figure, cells, None)
    first_is_larger = first > second
    return Row(figure, cells, 0 if first_is_larger == metrics.get(figure.name).higher_is_better else 1)


def column_names(summary: Summary, baseline: Summary | None) -> list[str]:
    """Return the heads of the comparison's columns: the options that differ, at least the warp."""
    if baseline is None:
        return [summary["warp"]]
    for keys in (("warp",), ("warp", "fill"), ("warp", "fill", "lens")):
        names = [", ".join(s[key] for key in keys) for s in (summary, baseline)]
        if names[0] != names[1]:
            return names
    return ["this run", "baseline"]


def summary_table(summary: Summary, baseline: Summary | None = None) -> Table:
    """Return the table that ends a run: means (medians for times) with the bad tail beside them.

    The better column of each quality line is bold and starred, so that it reads without colour too.
    """
    from rich.table import Table
    from rich.text import Text

    title = f"{summary['trace']} at {summary['latency_ms']:g} ms, scene {summary['scene']}, {summary['frames']} frames"
    table = Table(title=title, title_justify="left", caption=_caption(summary, baseline), caption_justify="left")
    table.add_column("")
    for name in column_names(summary, baseline):
        table.add_column(name, justify="right")
        table.add_column("p95", justify="right", style="dim")
    for number, row in enumerate(comparison_rows(summary, baseline)):
        if number == len(QUALITY_FIGURES):
            table.add_section()
        cells: list[Text] = [Text(_head(row.figure))]
        for column, (main, tail) in enumerate(row.cells):
            best = row.best == column
            cells += [Text(f"{main} *" if best else main, style="bold green" if best else ""), Text(tail)]
        table.add_row(*cells)
    return table


def _head(figure: Figure) -> str:
    label = f"Time, {figure.label.lower()}" if figure in TIME_FIGURES else figure.label
    return f"{label} [{figure.unit}]" if figure.unit else label


def _caption(summary: Summary, baseline: Summary | None) -> str:
    clock = "GPU timers" if summary["clock"] == "gpu" else "wall clock"
    text = f"mean over measured pictures; times: median per eye, {clock};\np95: the worst 5 % begin there"
    if baseline is None:
        return text
    return f"{text}; *: better of the two; {baseline['warp']}: fill {baseline['fill']}, lens {baseline['lens']}"
