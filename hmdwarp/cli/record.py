"""hmdwarp record: a head's motion as a trace."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from . import _options as o


def record(
    out: Annotated[Path, typer.Option("--out", help="The trace to write: a new file.")],
    source: Annotated[
        str, typer.Option("--source", help="openxr (a headset), desktop (a window) or synthetic (made up).")
    ] = "openxr",
    seconds: Annotated[
        float | None, typer.Option("--seconds", help="Stop after so long; else at Ctrl-C.", show_default=False)
    ] = None,
    rate: Annotated[
        float | None,
        typer.Option(
            "--rate", help="Poses a second; by default as the display refreshes, made up 90.", show_default=False
        ),
    ] = None,
    kind: Annotated[
        str,
        typer.Option(
            "--kind", help="Of made-up motion: still, look-around, reversals, walk or fast-turns; it ends by itself."
        ),
    ] = "look-around",
    scene: o.Scene = "room",
    reconnect: Annotated[
        float, typer.Option("--reconnect", help="Seconds to wait for a runtime that went away.")
    ] = 60.0,
    hang: Annotated[float, typer.Option("--hang", help="Seconds after which a silent runtime is given up.")] = 5.0,
    quiet: Annotated[bool, typer.Option("--quiet", help="Print nothing but errors.")] = False,
) -> None:
    """Record a head while it moves: what came is on the disk within a second, whatever happens. A window shows the scene."""
    from ..run.live.recording import RecordOptions
    from ..run.live.recording import record as go

    options = RecordOptions(
        source=source,
        out=out,
        seconds=seconds,
        rate_hz=rate,
        kind=kind,
        scene=scene,
        reconnect_s=reconnect,
        hang_s=hang,
    )
    go(options, (lambda text: None) if quiet else lambda text: typer.echo(text, err=True))
