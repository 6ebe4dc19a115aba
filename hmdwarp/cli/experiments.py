"""Commands of experiments over many cases."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import typer

from .. import report
from ..experiments import sweep
from ..experiments.bench import BenchOptions, MergeOptions
from ..experiments.bench.options import CompareOptions
from ..experiments.thesis.experiment import ThesisOptions
from ..run.requirements import Requirements
from ._options import JSON, QUIET, Said, command_line, print_results, takes


@takes(BenchOptions, Requirements, JSON, QUIET)
def bench(said: Said) -> None:
    """Run every combination of warps, fills, latencies, scenes, traces and sizes.

    All see the same late frames; the result is error against time.
    """
    from ..experiments.bench import bench as run
    from ._show import run_experiment

    required, options = Requirements.of(said), BenchOptions.of(said, command=command_line())
    run_experiment(run, "instants", _tell_bench, options, said=said, required=required)


@takes(MergeOptions, JSON, QUIET)
def merge(said: Said) -> None:
    """Join benches of several machines or parts: quality once, times for each machine.

    Fails where two machines showed different pictures.
    """
    from ..experiments.bench import merge as run

    result = run(MergeOptions.of(said, command=command_line()))
    print_results(said, result.data, lambda: _tell_bench(result), result.report)


def _tell_bench(result: sweep.ExperimentResult) -> None:
    from ..report.bench.rows import OF_BENCH, bench_table, verdict_text
    from ._show import paragraph

    rows = result.data["rows"]
    _tell_cases(rows, "bench", OF_BENCH, bench_table)
    paragraph(f"Timed by {result.data['clocks']['note']}.")
    for trace, axes in report.axes_of_traces(rows).items():
        paragraph(f"Axes of {trace}: {axes}.")
    of_rows = (note for row in rows for note in row["notes"])
    for note in dict.fromkeys([*result.data["notes"], *of_rows]):
        paragraph(f"note: {note}")
    for verdict in result.data["winners"]:
        paragraph(verdict_text(verdict))


def _tell_cases(rows: Iterable[Any], name: str, conditions: Any, table: Callable[[list[Any]], Any]) -> None:
    """Print the table of the first cases, and where all of them are."""
    from ..report.bench.rows import first_cases
    from ._show import console, paragraph

    shown, count = first_cases(rows, sweep.MOST_SHOWN, conditions)
    console().print(table([*shown.values()]))
    if count > sweep.MOST_SHOWN:
        paragraph(f"These are the first {sweep.MOST_SHOWN} of {count} cases; {name}.csv and {name}.json have all.")


@takes(CompareOptions, Requirements, JSON, QUIET)
def compare(said: Said) -> None:
    """Run every strategy of remote rendering on the same heads, over the same coded link.

    Error, time, traffic and memory, and which class of clients can run what.
    """
    from ..experiments.bench import compare as run
    from ._show import run_experiment

    required, options = Requirements.of(said), CompareOptions.of(said, command=command_line())
    run_experiment(run, "runs", _tell_compare, options, said=said, required=required)


def _tell_compare(result: sweep.ExperimentResult) -> None:
    from ..report.compare_page import OF_COMPARE, compare_table
    from ._show import paragraph

    _tell_cases(result.data["rows"], "compare", OF_COMPARE, compare_table)
    for entry in result.data["left_out"]:
        paragraph(f"note: {entry['strategy']} is left out: {entry['why']}")


@takes(ThesisOptions, JSON, QUIET)
def thesis(said: Said) -> None:
    """Run the thesis's figures, times and claims again, each with its number and a verdict.

    Each run is kept in the folder as soon as it is done: --resume goes on there.
    """
    from ..experiments.thesis.thesis_run import run_thesis
    from ..study.analysis.full_analysis import published_ratings
    from ._show import run_experiment

    options = ThesisOptions.of(said, command=command_line())
    run_experiment(run_thesis, "runs", _tell_thesis, options, published_ratings, said=said)


def _tell_thesis(result: sweep.ExperimentResult) -> None:
    from ._show import in_columns

    in_columns((each["verdict"], each["claim"]) for each in result.data["experiments"])
    typer.echo(", ".join(f"{count} {verdict}" for verdict, count in result.data["verdicts"].items()))
