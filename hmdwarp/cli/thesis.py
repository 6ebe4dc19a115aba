"""hmdwarp thesis: the experiments that this project began with, again."""

from __future__ import annotations

import typer

from ..experiments import sweep
from ..experiments.thesis import ThesisOptions
from ._options import QUIET, Said, command_line, takes


@takes(ThesisOptions, QUIET)
def thesis(said: Said) -> None:
    """Run the thesis's figures, times and claims again, each with its number and a verdict.

    Each run is kept in the folder as soon as it is done: --resume goes on there.
    """
    from ..experiments.thesis import run_thesis
    from ..study.analysis import published_ratings
    from ._show import run_experiment

    options = ThesisOptions.of(said, command=command_line())
    run_experiment(run_thesis, "runs", _tell, options, published_ratings, quiet=said["quiet"])


def _tell(result: sweep.ExperimentResult) -> None:
    from ._show import in_columns

    in_columns((each["verdict"], each["claim"]) for each in result.data["experiments"])
    typer.echo(", ".join(f"{count} {verdict}" for verdict, count in result.data["verdicts"].items()))
