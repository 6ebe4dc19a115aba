"""hmdwarp replay: a recorded head trace through the whole pipeline."""

from __future__ import annotations

from functools import partial

import typer

from .. import run
from ..run.options import RunOptions
from ..run.requirements import Baseline, Requirements, hold
from ._options import QUIET, Said, command_line, takes


@takes(RunOptions, Requirements, Baseline, QUIET)
def replay(said: Said) -> None:
    """Replay a head trace with late frames, warp each to the newest pose, and measure it."""
    options, required, baseline = RunOptions.of(said, command=command_line()), Requirements.of(said), Baseline.of(said)
    required.prepare(force=options.force)
    stored = baseline.stored(options.out)
    result = _run(options, said["quiet"])
    missed = required.missed([result.summary], result.against)
    hold([*missed, *baseline.differences(stored, result.folder, options.command)])


def _run(options: RunOptions, quiet: bool) -> run.ReplayResult:
    from ..report import axes_of_traces, summary_table, transit_lines
    from ._show import console, steps

    with steps("refreshes", quiet=quiet) as (progress, screen):
        result = run.replay(options, progress, *([] if quiet else [partial(screen.print, soft_wrap=True)]))
    if quiet:
        return result
    console().print(summary_table(result.summary, *result.against))
    for trace, axes in axes_of_traces([result.summary]).items():
        typer.echo(f"axes of {trace}: {axes}")
    for line in transit_lines(result.summary):
        typer.echo(line)
    for note in result.summary["notes"]:
        typer.echo(f"note: {note}")
    typer.echo(f"report: {result.report}")
    return result
