"""hmdwarp thesis: the experiments that this project began with, again."""

from __future__ import annotations

import typer

from ..experiments.thesis import ThesisOptions
from ._options import QUIET, Said, command_line, takes


@takes(ThesisOptions, QUIET)
def thesis(said: Said) -> None:
    """Run the thesis's figures, times and claims again, each with its number and a verdict.

    Each run is kept in the folder as soon as it is done: --resume goes on there.
    """
    _run(ThesisOptions.of(said, command=command_line()), said["quiet"])


def _run(options: ThesisOptions, quiet: bool) -> None:
    from ..experiments.thesis import run_thesis
    from ..study.thesis_ratings import published_ratings
    from ._show import in_columns, sayer, steps

    with steps("runs", quiet=quiet) as (progress, _):
        result = run_thesis(options, published_ratings, progress, sayer(quiet))
    if not quiet:
        in_columns((one["verdict"], one["claim"]) for one in result.data["experiments"])
        typer.echo(", ".join(f"{count} {verdict}" for verdict, count in result.data["verdicts"].items()))
        typer.echo(f"report: {result.report}")
    result.raise_failures()
