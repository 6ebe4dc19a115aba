"""hmdwarp bench: what accuracy costs in time."""

from __future__ import annotations

import typer

from ..experiments import sweep
from ..experiments.bench import BenchOptions, MergeOptions
from ..run.requirements import Requirements
from ._options import QUIET, Said, command_line, takes


@takes(BenchOptions, Requirements, QUIET)
def bench(said: Said) -> None:
    """Run every combination of warps, fills, latencies, scenes, traces and sizes.

    All see the same late frames; the result is error against time.
    """
    from ..experiments.bench import bench as run
    from ._show import run_experiment

    required, options = Requirements.of(said), BenchOptions.of(said, command=command_line())
    run_experiment(run, "instants", _tell, options, quiet=said["quiet"], required=required)


@takes(MergeOptions, QUIET)
def merge(said: Said) -> None:
    """Join benches of several machines or parts: quality once, times for each machine.

    Fails where two machines showed different pictures.
    """
    from ..experiments.bench import merge as run

    result = run(MergeOptions.of(said, command=command_line()))
    if not said["quiet"]:
        _tell(result)
        typer.echo(f"report: {result.report}")


def _tell(result: sweep.ExperimentResult) -> None:
    from ..experiments.bench.notes import answer
    from ..experiments.sweep import MOST_SHOWN
    from ..report import axes_of_traces
    from ..report.bench import bench_table, first_cases
    from ._show import console, paragraph

    screen, rows = console(), result.data["rows"]
    shown, count = first_cases(rows, MOST_SHOWN)
    screen.print(bench_table(shown, width=screen.width))
    if count > MOST_SHOWN:
        paragraph(f"These are the first {MOST_SHOWN} of {count} cases; bench.csv and bench.json have all.")
    paragraph(f"Timed by {result.data['clocks']['note']}. Copying moves {result.data['copy_gb_s']:.1f} GB/s.")
    for trace, axes in axes_of_traces(rows).items():
        paragraph(f"Axes of {trace}: {axes}.")
    of_rows = (note for row in rows for note in row["notes"])
    for note in dict.fromkeys([*result.data["notes"], *of_rows]):
        paragraph(f"note: {note}")
    for sentence in answer(result.data["choice"]) if result.data["choice"] else ():
        paragraph(sentence)
