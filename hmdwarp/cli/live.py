"""hmdwarp live: a headset, or a window on the desktop."""

from __future__ import annotations

import typer

from ..run.options import LiveOptions
from ._options import QUIET, Said, command_line, takes
from ._show import sayer


@takes(LiveOptions, QUIET)
def live(said: Said) -> None:
    """Show late frames live, each warped to the newest pose: in the headset, or in a window (h shows its keys)."""
    run(LiveOptions.of(said, command=command_line()), said["quiet"])


def run(options: LiveOptions, quiet: bool) -> None:
    """Run it and print what came out."""
    from ..run import live as go

    result = go(options, sayer(quiet))
    if not quiet:
        for line in result.describe():
            typer.echo(line)
