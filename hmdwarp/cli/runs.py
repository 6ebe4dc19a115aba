"""Commands that run: a recorded trace, a headset or a window, a recorder, a server for others."""

from __future__ import annotations

from functools import partial

import typer

from .. import run
from ..run.options import LiveOptions, ProxyRunOptions, RecordOptions, RunOptions, ServeOptions
from ..run.requirements import Baseline, Requirements, hold
from ._options import QUIET, Said, command_line, takes
from ._show import sayer


@takes(RunOptions, Requirements, Baseline, QUIET)
def replay(said: Said) -> None:
    """Replay a head trace with late frames, warp each to the newest pose, and measure it."""
    options, required, baseline = RunOptions.of(said, command=command_line()), Requirements.of(said), Baseline.of(said)
    required.prepare(force=options.force, has_baseline=baseline.baseline is not None)
    stored = baseline.stored(options.out)
    result = _replay(options, said["quiet"])
    differences = baseline.differences(stored, result.folder, options.command)
    hold(required.missed([result.summary], result.against, differences))


def _replay(options: RunOptions, quiet: bool) -> run.ReplayResult:
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


@takes(LiveOptions, QUIET)
def live(said: Said) -> None:
    """Show late frames live, each warped to the newest pose.

    In the headset, or in a window (h shows its keys).
    """
    run_live(LiveOptions.of(said, command=command_line()), said["quiet"])


def run_live(options: LiveOptions, quiet: bool) -> None:
    """Run it and print what came out."""
    from ..run import live as go

    result = go(options, sayer(quiet))
    if not quiet:
        for line in result.describe():
            typer.echo(line)


@takes(RecordOptions, QUIET)
def record(said: Said) -> None:
    """Record a head while it moves; each pose is on the disk within a second.

    A window shows the scene.
    """
    from ..run import record as go

    go(RecordOptions.of(said), sayer(said["quiet"]))


@takes(ServeOptions, QUIET)
def serve(said: Said) -> None:
    """Serve frames to clients in other processes or on other machines, until Ctrl-C.

    Clients are 'hmdwarp live --connect', 'hmdwarp replay --connect', 'hmdwarp proxy', programs that
    speak the protocol of docs/feed.md and, with --web, browsers.
    """
    from ..run import serve as go

    go(ServeOptions.of(said), sayer(said["quiet"]))


@takes(ProxyRunOptions, QUIET)
def proxy(said: Said) -> None:
    """Warp a server's frames for clients that only show or turn them, until Ctrl-C.

    It stands between 'hmdwarp serve' and 'hmdwarp live --connect' or 'hmdwarp replay --connect'
    with --warp none or rotation.
    """
    from ..run import proxy as go

    go(ProxyRunOptions.of(said), sayer(said["quiet"]))
