"""The figures of a run in the order, units and rounding in which people read them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import attrs

from ..metrics import LEAST_INSTANTS, STAGES, Figure, excludes_zero, metrics, metrics_in_order

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
    # (main figure with its interval, tail) of each run, as text.
    cells: tuple[tuple[str, str], ...]
    # Index of the better run, if any.
    best: int | None


def comparison_rows(summary: Summary, baseline: Summary | None) -> list[Row]:
    """Return the rows of quality, then of time per eye; two cells each if there is a baseline.

    The better of two means is marked if their difference over the instants holds. Time and holes
    are no contest: a warp that does nothing is quick and leaves nothing empty.
    """
    summaries = [summary] if baseline is None else [summary, baseline]
    rows = [
        Row(figure, tuple(_mean_cells(figure, s["quality"][figure.name]) for s in summaries), _best(figure, baseline))
        for figure in QUALITY_FIGURES
    ]
    for figure in TIME_FIGURES:
        times = [s["time_ms"][figure.name] for s in summaries]
        rows.append(Row(figure, tuple((figure.text(e["median"]), figure.text(e["p95"])) for e in times), None))
    return rows


def _mean_cells(figure: Figure, entry: Mapping[str, Any]) -> tuple[str, str]:
    mean, interval = figure.text(entry["mean"]), entry.get("interval")
    if interval is not None:
        mean += f" ±{figure.text((interval[1] - interval[0]) / 2)}"
    return mean, figure.text(entry["p95"])


def _best(figure: Figure, baseline: Summary | None) -> int | None:
    found = (baseline or {}).get("difference", {}).get(figure.name)
    if figure.name not in _CONTESTS or found is None or not excludes_zero(found["interval"]):
        return None
    return 0 if (found["mean"] > 0) == metrics.get(figure.name).higher_is_better else 1


def how_sure(summary: Summary, *, mark: str | None) -> str:
    """Return what the intervals are and what a mark says, or why there are none.

    mark: None where nothing is compared.
    """
    if all(entry.get("interval") is None for entry in summary["quality"].values()):
        return f"No intervals{f' and no {mark}' if mark else ''}: they take {LEAST_INSTANTS} measured refreshes"
    return "±: 95 % interval of the mean" + (f"; {mark}: the better of the two, for sure (95 %)" if mark else "")


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
    from rich.box import SIMPLE_HEAD
    from rich.table import Table
    from rich.text import Text

    title = f"{summary['trace']} at {summary['latency_ms']:g} ms, scene {summary['scene']}, {summary['frames']} frames"
    table = Table(
        title=title, title_justify="left", caption=_caption(summary, baseline), caption_justify="left",
        box=SIMPLE_HEAD, show_edge=False, pad_edge=False,
    )  # fmt: skip
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


def axes_of_traces(summaries: Iterable[Summary]) -> dict[str, str]:
    """Return the axes in which each recorded trace was read, by its name."""
    return {str(one["trace"]): str(one["trace_axes"]) for one in summaries if one.get("trace_axes")}


def _head(figure: Figure) -> str:
    label = f"Time, {figure.label.lower()}" if figure in TIME_FIGURES else figure.label
    return f"{label} [{figure.unit}]" if figure.unit else label


def _caption(summary: Summary, baseline: Summary | None) -> str:
    clock = "GPU timers" if summary["clock"] == "gpu" else "wall clock"
    lines = ["mean over measured pictures; p95: the worst 5 % begin there", f"times: median per eye, {clock}"]
    if baseline is not None:
        lines[1] += f"; {baseline['warp']}: fill {baseline['fill']}, lens {baseline['lens']}"
    return "\n".join([*lines, how_sure(summary, mark=None if baseline is None else "*")])
