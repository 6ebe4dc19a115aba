"""hmdwarp study measure: figures of every trial's pictures."""

from __future__ import annotations

from pathlib import Path

import attrs
import typer

from ...options import Declared, group
from ...study.measure_options import MeasureOptions
from .._options import QUIET, Said, takes
from ._options import origin_of, simulated_field, store_field, study_field


@attrs.frozen
class MeasureCommand(Declared):
    """A study, and how to measure it."""

    study: str = study_field()
    store: Path | None = store_field()
    simulated: bool = simulated_field()
    options: MeasureOptions = group(MeasureOptions)


@takes(MeasureCommand, QUIET)
def measure(said: Said) -> None:
    """Replay each trial's head trace and measure its pictures against zero latency; resumable."""
    from ...experiments.sweep import raise_failed
    from ...study.design import load_design
    from ...study.measure import measure_study
    from ...study.store import Store, folder_to_read
    from .._show import steps

    wanted, quiet = MeasureCommand.of(said), said["quiet"]
    origin = origin_of(wanted.options.pilot, wanted.simulated)
    design = load_design(wanted.study, checked=False)  # only its name is needed
    with (
        Store(folder_to_read(design, wanted.store, origin), study=design.name) as data,
        steps("refreshes", quiet=quiet) as (progress, screen),
    ):
        found = measure_study(data, wanted.options, progress, *([] if quiet else [screen.print]))
    if not quiet:
        for line in found.describe():
            typer.echo(line)
    raise_failed(found.failed, found.measured + len(found.failed), "the others are kept: run it again")
