"""hmdwarp replay: a recorded head trace through the whole pipeline."""

from __future__ import annotations

from functools import partial

import typer

from ..run.options import RunOptions
from ._options import QUIET, Said, command_line, takes


@takes(RunOptions, QUIET)
def replay(said: Said) -> None:
    """Replay a head trace with late frames, warp each to the newest pose, and measure it."""
    _run(RunOptions.of(said, command=command_line()), said["quiet"])


def _run(options: RunOptions, quiet: bool) -> None:
    from ..report import axes_of_traces, summary_table, transit_lines
    from ..run import replay as run
    from ._show import console, steps

    with steps("refreshes", quiet=quiet) as (progress, screen):
        result = run(options, progress, *([] if quiet else [partial(screen.print, soft_wrap=True)]))
    if quiet:
        return
    console().print(summary_table(result.summary, *result.against))
    for trace, axes in axes_of_traces([result.summary]).items():
        typer.echo(f"axes of {trace}: {axes}")
    for line in transit_lines(result.summary):
        typer.echo(line)
    for note in result.summary["notes"]:
        typer.echo(f"note: {note}")
    typer.echo(f"report: {result.report}")
