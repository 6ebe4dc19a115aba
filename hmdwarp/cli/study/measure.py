"""hmdwarp study measure: figures of every trial's pictures."""

from __future__ import annotations

from typing import Annotated

import typer

from ._options import PilotOption, QuietOption, SimulatedOption, StoreOption, StudyArgument


def measure(
    study: StudyArgument,
    store: StoreOption = None,
    every: Annotated[int, typer.Option("--every", help="Measure every n-th refresh.")] = 10,
    size: Annotated[
        str | None,
        typer.Option(
            "--size", help="WxH pixels of one eye; by default as shown. Fewer are faster.", show_default=False
        ),
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option(
            help="Measuring processes; 0 measures in the loop. Default: one per core, at most 8.", show_default=False
        ),
    ] = None,
    again: Annotated[
        bool, typer.Option("--again", help="Re-measure trials already measured with these options.")
    ] = False,
    pilot: PilotOption = False,
    simulated: SimulatedOption = False,
    quiet: QuietOption = False,
) -> None:
    """Replay each trial's head trace and measure its pictures against zero latency; resumable."""
    from ...errors import InputError
    from ...pipeline.options import parse_size
    from ...study.design import load_design
    from ...study.measure import MeasureOptions, measure_study
    from ...study.store import PERSON, PILOT, SIMULATED, Store, folder_to_read
    from .._show import steps

    if pilot and simulated:
        raise InputError("--pilot and --simulated: their data lie apart; measure one after the other")
    origin = PILOT if pilot else SIMULATED if simulated else PERSON
    design = load_design(study, checked=False)  # only its name is needed
    options = MeasureOptions(
        every=every, size=None if size is None else parse_size(size), again=again, pilot=pilot, workers=workers
    )
    with (
        Store(folder_to_read(design, store, origin), study=design.name) as data,
        steps("refreshes", quiet=quiet) as (progress, screen),
    ):
        found = measure_study(data, options, progress, *([] if quiet else [screen.print]))
    if not quiet:
        for line in found.describe():
            typer.echo(line)
