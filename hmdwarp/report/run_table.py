"""The figures of runs side by side, in the order and rounding in which people read them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import attrs

from ..metrics import LEAST_INSTANTS, Figure, excludes_zero, metrics, metrics_in_order
from .run_texts import MISS_FIGURES, QUALITY_FIGURES, TIME_FIGURES, Summary, source_text
from .tables import terminal_table

if TYPE_CHECKING:
    from rich.table import Table

_CONTESTS = frozenset(metric.name for metric in metrics_in_order() if metric.is_contest)


@attrs.frozen
class Row:
    """One line of the comparison."""

    figure: Figure
    # (main figure with its interval, tail) of each run, as text.
    cells: tuple[tuple[str, str], ...]
    # Index of the better run, if any.
    best: int | None


def comparison_rows(summary: Summary, *baselines: Summary) -> list[Row]:
    """Return the rows of quality, then of time per eye, then of a client that misses refreshes.

    Each has a cell for the run and each baseline.

    The run is marked if it is better than each baseline, a baseline if it is better than the run
    and no other has a better mean: if the difference over the instants holds. Time and holes are no
    contest: a warp that does nothing is quick and leaves nothing empty.
    """
    summaries = [summary, *baselines]
    rows = [
        Row(figure, tuple(_mean_cells(figure, s["quality"][figure.name]) for s in summaries), _best(figure, baselines))
        for figure in QUALITY_FIGURES
    ]
    for figure in TIME_FIGURES:
        times = [s["time_ms"][figure.name] for s in summaries]
        rows.append(Row(figure, tuple((figure.text(e["median"]), figure.text(e["p95"])) for e in times), None))
    if "miss" in summary:
        entries = [summary.get("miss", {}) for summary in summaries]
        rows += [Row(each, tuple((each.text(e.get(each.name)), "") for e in entries), None) for each in MISS_FIGURES]
    return rows


def _mean_cells(figure: Figure, entry: Mapping[str, Any]) -> tuple[str, str]:
    mean, interval = figure.text(entry["mean"]), entry.get("interval")
    if interval is not None:
        mean += f" ±{figure.text((interval[1] - interval[0]) / 2)}"
    return mean, figure.text(entry["p95"])


def _best(figure: Figure, baselines: Sequence[Summary]) -> int | None:
    if figure.name not in _CONTESTS or not baselines:
        return None
    sign = 1 if metrics.get(figure.name).higher_is_better else -1
    found = [baseline.get("difference", {}).get(figure.name) for baseline in baselines]
    # How much better the run is than each, 0 where that is not sure.
    gains = [
        sign * difference["mean"] if difference and excludes_zero(difference["interval"]) else 0.0
        for difference in found
    ]
    if min(gains) > 0:
        return 0
    return 1 + gains.index(min(gains)) if min(gains) < 0 else None


def how_sure(summary: Summary, *, mark: str | None) -> str:
    """Return what the intervals are and what a mark says, or why there are none.

    mark: None where nothing is compared.
    """
    if all(entry.get("interval") is None for entry in summary["quality"].values()):
        return f"No intervals{f' and no {mark}' if mark else ''}: they need {LEAST_INSTANTS} measured refreshes"
    return "±: 95 % interval of the mean" + (f"; {mark}: the best of the line, for sure (95 %)" if mark else "")


def column_names(summary: Summary, *baselines: Summary) -> list[str]:
    """Return the heads of the comparison's columns: the options that differ, at least the warp."""
    for keys in (("warp",), ("warp", "fill"), ("warp", "fill", "lens")):
        names = [", ".join(s[key] for key in keys) for s in (summary, *baselines)]
        if len(set(names)) == len(names):
            return names
    return ["this run", *(f"baseline {number}" for number in range(1, len(names)))]


def summary_table(summary: Summary, *baselines: Summary) -> Table:
    """Return the table that ends a run: means (medians for times) with the bad tail next to them.

    The best column of each quality line is bold and starred, so that it reads without colour too.
    Only the first baseline has its tail next to it, where a terminal has room for no more.
    """
    from rich.text import Text

    title = f"{summary['trace']} at {summary['latency_ms']:g} ms, {source_text(summary)}, {summary['frames']} frames"
    table = terminal_table(title=title, caption=_caption(summary, baselines))
    table.add_column("")
    tails = 2 if len(baselines) < 2 else 1
    for number, name in enumerate(column_names(summary, *baselines)):
        table.add_column(name, justify="right")
        if number < tails:
            table.add_column("p95", justify="right", style="dim")
    for number, row in enumerate(comparison_rows(summary, *baselines)):
        if number in (len(QUALITY_FIGURES), len(QUALITY_FIGURES + TIME_FIGURES)):
            table.add_section()
        cells: list[Text] = [Text(_head(row.figure))]
        for column, (main, tail) in enumerate(row.cells):
            best = row.best == column
            cells.append(Text(f"{main} *" if best else main, style="bold green" if best else ""))
            if column < tails:
                cells.append(Text(tail))
        table.add_row(*cells)
    return table


def _head(figure: Figure) -> str:
    label = f"Time, {figure.label.lower()}" if figure in TIME_FIGURES else figure.label
    return f"{label} [{figure.unit}]" if figure.unit else label


def _caption(summary: Summary, baselines: Sequence[Summary]) -> str:
    clock = "GPU timers" if summary["clock"] == "gpu" else "wall clock"
    lines = ["mean over measured pictures; p95: the worst 5 % begin there", f"times: median per eye, {clock}"]
    lines[1] += "".join(
        f"; {baseline['warp']}: fill {baseline['fill']}, lens {baseline['lens']}" for baseline in baselines
    )
    return "\n".join([*lines, how_sure(summary, mark="*" if baselines else None)])
