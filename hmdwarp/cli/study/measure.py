"""hmdwarp study measure: the pictures of every trial, afterwards."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def measure(
    study: Annotated[str, typer.Argument(help="The study's .toml file, or the name of one that comes along.")],
    store: Annotated[
        Path | None, typer.Option("--store", help="The data; by default beside the file.", show_default=False)
    ] = None,
    every: Annotated[int, typer.Option("--every", help="Measure every n-th refresh.")] = 10,
    size: Annotated[
        str | None,
        typer.Option(
            "--size", help="WxH pixels of one eye; by default as it was shown. Less is faster.", show_default=False
        ),
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option(
            help="Measuring processes; 0 measures in the loop. Default: one per core, at most 8.", show_default=False
        ),
    ] = None,
    again: Annotated[bool, typer.Option("--again", help="Also what was measured before in the same way.")] = False,
    pilot: Annotated[bool, typer.Option("--pilot", help="Pilot sessions instead of those of participants.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", help="Print nothing but errors.")] = False,
) -> None:
    """Replay each trial's head trace and measure its pictures against no latency at all; go on where it was left."""
    from ...pipeline.options import parse_size
    from ...study.design.read import load_design
    from ...study.measure import MeasureOptions, measure_study
    from ...study.store import Store, store_folder
    from .._show import steps

    design = load_design(study, checked=False)  # nothing but its name is needed
    options = MeasureOptions(
        every=every, size=None if size is None else parse_size(size), again=again, pilot=pilot, workers=workers
    )
    with (
        Store(store_folder(design, store), study=design.name) as data,
        steps("refreshes", quiet=quiet) as (progress, screen),
    ):
        found = measure_study(data, options, progress, *([] if quiet else [screen.print]))
    if not quiet:
        for line in found.told():
            typer.echo(line)
