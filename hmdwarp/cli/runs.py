"""Commands that run: a recorded trace, a headset or a window, a recorder, a server for others."""

from __future__ import annotations

import sys
from functools import partial

import attrs
import typer

from .. import run
from ..errors import InputError
from ..options import AUTO
from ..run.options import OFFSCREEN, LiveOptions, ProxyRunOptions, RecordOptions, RunOptions, ServeOptions
from ..run.requirements import Gate
from ._options import JSON, QUIET, Said, command_line, print_results, takes
from ._show import sayer


@takes(RunOptions, Gate, JSON, QUIET)
def replay(said: Said) -> None:
    """Replay a head trace with late frames, warp each to the newest pose, and measure it."""
    from ..report import axes_of_traces, summary_table, transit_lines
    from ._show import console, steps

    options, gate, quiet = RunOptions.of(said, command=command_line()), Gate.of(said), said["quiet"]
    gate.prepare(force=options.force)
    judge = gate.judge_of(options.out)
    if AUTO in (options.warp, options.guard):
        choice = run.choose(options, sayer(quiet))
        if not quiet and not said["json"]:
            typer.echo("\n".join((choice.command(sys.argv[2:]), *choice.notes)))
        options = attrs.evolve(choice.options, command=choice.command(sys.argv[2:]))
    with steps("refreshes", quiet=quiet) as (progress, screen):
        result = run.replay(options, progress, sayer(True) if quiet else partial(screen.print, soft_wrap=True), judge)

    def as_text() -> None:
        console().print(summary_table(result.summary, *result.against))
        lines = [f"axes of {trace}: {axes}" for trace, axes in axes_of_traces([result.summary]).items()]
        lines += [*transit_lines(result.summary), *(f"note: {note}" for note in result.summary["notes"])]
        typer.echo("\n".join(lines))

    print_results(said, result.summary, as_text, result.report)
    if result.verdict is not None:
        gate.store(result.verdict, result.folder)
        gate.end(result.verdict)
        sayer(quiet)(result.verdict.headline)


@takes(RunOptions, JSON, QUIET)
def choose(said: Said) -> None:
    """Choose warp, fill and guard band for a budget, and print the replay that has them.

    For --budget, or that of --client: by --bench, else by a short bench on a few instants of this
    run. 'replay --warp auto' does the same and runs it.
    """
    if said["warp"] not in (None, AUTO):
        raise InputError(f"choose --warp {said['warp']}: it names the warp; leave --warp out")
    said["warp"] = AUTO
    if said["guard"] is None and not said["wide"] and said["rendered_size"] is None:
        said["guard"] = AUTO
    options = RunOptions.of(said)
    choice = run.choose(options, sayer(said["quiet"] or said["json"]))
    level, *_ = levels = [
        {"warp": one.warp, "fill": one.fill, "total_ms": one.total_ms, "flip": one.error, "psnr_db": one.psnr_db}
        for one in (choice.level, *choice.levels)
        if one is not None
    ]
    data = {
        "command": choice.command(sys.argv[2:]),
        "budget_ms": options.budget_ms,
        "guard": choice.options.guard,
        **level,
        "range_ms": choice.range_ms,
        "levels": levels[1:],
        "notes": choice.notes,
    }
    print_results(said, data, lambda: typer.echo("\n".join((choice.command(sys.argv[2:]), *choice.notes))))


@takes(LiveOptions, JSON, QUIET)
def live(said: Said) -> None:
    """Show late frames live, each warped to the newest pose.

    In the headset, or in a window (h shows its keys).
    """
    from ..run import live as go
    from ._show import steps

    options = LiveOptions.of(said, command=command_line())
    shown = options.source != OFFSCREEN  # then its loop does nothing more
    with steps("pictures", quiet=said["quiet"] or shown) as (progress, _):
        after = [] if shown else [lambda number: progress(number, options.pictures or 0)]
        result = go(options, sayer(said["quiet"]), *after)
    print_results(said, result.summary, lambda: typer.echo("\n".join(result.describe())))


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
