"""Commands that run: a recorded trace, a headset or a window, a recorder, a server for others."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path
from typing import Any

import attrs
import typer

from .. import report, run
from ..base import AUTO, Declared, InputError, RequirementError, force_field, option, out_field
from ..run.options import OFFSCREEN, LiveOptions, ProxyRunOptions, RecordOptions, RunOptions, ServeOptions
from ..run.requirements import Gate, Tolerance, tolerance_field
from ._options import JSON, QUIET, Said, as_json, command_line, print_results, takes
from ._show import sayer, steps


def _choose(options: RunOptions, quiet: bool) -> run.Choice:
    with steps("trials", quiet=quiet) as (progress, screen):
        return run.choose(options, sayer(True) if quiet else partial(screen.print, soft_wrap=True), progress)


@takes(RunOptions, Gate, JSON, QUIET)
def replay(said: Said) -> None:
    """Replay a head trace with late frames, warp each to the newest pose, and measure it."""
    from ._show import console

    options, gate, quiet = RunOptions.of(said, command=command_line()), Gate.of(said), said["quiet"]
    gate.prepare(force=options.force)
    judge = gate.judge_of(options.out)
    if AUTO in (options.warp, options.guard):
        choice = _choose(options, quiet)
        if not quiet and not said["json"]:
            typer.echo("\n".join((choice.command(sys.argv[2:]), *choice.notes)))
        options = attrs.evolve(choice.options, command=choice.command(sys.argv[2:]))
    with steps("refreshes", quiet=quiet) as (progress, screen):
        result = run.replay(options, progress, sayer(True) if quiet else partial(screen.print, soft_wrap=True), judge)

    def as_text() -> None:
        console().print(report.summary_table(result.summary, *result.against))
        lines = [f"axes of {trace}: {axes}" for trace, axes in report.axes_of_traces([result.summary]).items()]
        lines += [*(f"note: {note}" for note in result.summary["notes"])]
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
    if said["guard"] is None:
        said["guard"] = AUTO
    options = RunOptions.of(said)
    choice = _choose(options, said["quiet"])
    levels = [
        {"warp": one.warp, "fill": one.fill, "total_ms": one.total_ms, "flip": one.error, "psnr_db": one.psnr_db}
        for one in (choice.level, *choice.levels)
        if one is not None
    ]
    line, guard = choice.command(sys.argv[2:]), choice.options.guard
    data: Any = {"command": line, "budget_ms": options.budget_ms, "guard": guard, **levels[0]}
    data |= {"range_ms": choice.range_ms, "levels": levels[1:], "notes": choice.notes}
    print_results(said, data, lambda: typer.echo("\n".join((line, *choice.notes))))


@takes(LiveOptions, JSON, QUIET)
def live(said: Said) -> None:
    """Show late frames live, each warped to the newest pose.

    In the headset, or in a window (h shows its keys).
    """
    options = LiveOptions.of(said, command=command_line())
    shown = options.source != OFFSCREEN  # then its loop does nothing more
    with steps("pictures", quiet=said["quiet"] or shown) as (progress, _):
        after = [] if shown else [lambda number: progress(number, options.pictures or 0)]
        result = run.live(options, sayer(said["quiet"]), *after)
    print_results(said, result.summary, lambda: typer.echo("\n".join(result.describe())))


@takes(RecordOptions, QUIET)
def record(said: Said) -> None:
    """Record a head while it moves; each pose is on the disk within a second.

    A window shows the scene.
    """
    run.record(RecordOptions.of(said), sayer(said["quiet"]))


@takes(ServeOptions, QUIET)
def serve(said: Said) -> None:
    """Serve frames to clients in other processes or on other machines, until Ctrl-C.

    Clients are 'hmdwarp live --connect', 'hmdwarp replay --connect', 'hmdwarp proxy', programs that
    speak the protocol of docs/feed.md and, with --web, browsers.
    """
    run.serve(ServeOptions.of(said), sayer(said["quiet"]))


@takes(ProxyRunOptions, QUIET)
def proxy(said: Said) -> None:
    """Warp a server's frames for clients that only show or turn them, until Ctrl-C.

    It stands between 'hmdwarp serve' and 'hmdwarp live --connect' or 'hmdwarp replay --connect'
    with --warp none or rotation.
    """
    run.proxy(ProxyRunOptions.of(said), sayer(said["quiet"]))


@attrs.frozen
class _DiffOptions(Declared):
    """Two replays, and how near they have to be."""

    first: Path = option(attrs.NOTHING, "Folder of a replay, or its summary.json alone.", positional=True)
    second: Path = option(attrs.NOTHING, "Folder of another, or its summary.json.", positional=True)
    tolerance: Tolerance = tolerance_field()
    out: Path | None = out_field(None, "Folder for diff.html and diff.json.")
    force: bool = force_field()


@takes(_DiffOptions, JSON)
def diff(said: Said) -> None:
    """Compare two replays: set-up, figures, refreshes and pictures, times left out.

    Ends with status 4 where they differ.
    """
    options = _DiffOptions.of(said)
    found = options.tolerance.diff(report.StoredRun.of(options.first), report.StoredRun.of(options.second))
    if options.out is not None:
        with report.OutputFolder(options.out, owned=(report.DIFF_PAGE,), last="diff.json", force=options.force) as out:
            out.write_text(report.DIFF_PAGE, found.page(command_line()))
            out.write_json("diff.json", found.entry())
    if said["json"]:
        typer.echo(as_json(found.entry()))
    for note in [] if said["json"] else found.notes:
        typer.echo(f"note: {note}")
    if not found.is_equal:
        raise RequirementError("\n".join([found.told(), *found.lines()]))
    if not said["json"]:
        typer.echo(found.told())
