"""hmdwarp compare: strategies of remote rendering side by side."""

from __future__ import annotations

from ..experiments import sweep
from ..experiments.compare.options import CompareOptions
from ..run.requirements import Requirements
from ._options import QUIET, Said, command_line, takes


@takes(CompareOptions, Requirements, QUIET)
def compare(said: Said) -> None:
    """Run every strategy of remote rendering on the same heads, over the same coded link.

    Error, time, traffic and memory, and which class of clients can run what.
    """
    from ..experiments.compare import compare as run
    from ._show import run_experiment

    required, options = Requirements.of(said), CompareOptions.of(said, command=command_line())
    run_experiment(run, "runs", _tell, options, quiet=said["quiet"], required=required)


def _tell(result: sweep.ExperimentResult) -> None:
    from ..experiments.sweep import MOST_SHOWN
    from ..report.compare_page import compare_table, first_cases
    from ._show import console, paragraph

    rows = result.data["rows"]
    numbers, count = first_cases(rows, MOST_SHOWN)
    console().print(compare_table([rows[number] for number in numbers]))
    if count > MOST_SHOWN:
        paragraph(f"These are the first {MOST_SHOWN} of {count} cases; compare.csv and compare.json have all.")
    for entry in result.data["left_out"]:
        paragraph(f"note: {entry['strategy']} is left out: {entry['why']}")
