"""Commands on a study's store: what leaves it, what enters it, and what is measured of it."""

from __future__ import annotations

import sys
from pathlib import Path

import attrs
import typer

from ...errors import InputError
from ...options import Declared, force_field, group, option, out_field
from ...study.measure_options import MeasureOptions
from .._options import QUIET, Said, takes
from ._options import DataOptions, origin_of, simulated_field, store_field, store_of, study_field


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


@attrs.frozen
class ExportCommand(Declared):
    """An export."""

    study: str = study_field()
    out: Path = out_field(attrs.NOTHING, "A new folder for the table and the BIDS data set.")
    force: bool = force_field()
    data: DataOptions = group(DataOptions)
    parquet: bool | None = option(
        None, "Write ratings.parquet; by default where pyarrow is installed.", off="--no-parquet"
    )
    without_motion: bool = option(False, "Leave out the head motion, by which people can be recognised.")


@takes(ExportCommand, QUIET)
def export(said: Said) -> None:
    """Write the ratings as CSV and Parquet, and the study as BIDS with the head motion."""
    from ...study.design import load_design
    from ...study.export.write import ExportOptions
    from ...study.export.write import export as run
    from ...study.store import Store, folder_to_read
    from .._show import steps

    wanted = ExportCommand.of(said)
    origin = origin_of(wanted.data.pilot, wanted.data.simulated)
    design = load_design(wanted.study, checked=False)
    with Store(folder_to_read(design, wanted.data.store, origin), study=design.name) as data:
        contents = data.contents(pilot=wanted.data.pilot)
    options = ExportOptions(origin, wanted.parquet, wanted.force, not wanted.without_motion)
    with steps("recordings", quiet=said["quiet"]) as (progress, _):
        made = run(contents, design, wanted.out, options, progress)
    if not said["quiet"]:
        for line in made.notes:
            typer.echo(line)
        typer.echo(f"written: {made.folder}")


@attrs.frozen
class WithdrawOptions(Declared):
    """Who withdraws from which study."""

    study: str = study_field()
    code: str = option(attrs.NOTHING, "The participant's code.", positional=True, metavar="CODE")
    data: DataOptions = group(DataOptions)
    yes: bool = option(False, "Erase without confirmation.")


@takes(WithdrawOptions)
def withdraw(said: Said) -> None:
    """Erase all ratings, events and head traces of a participant; the code stays reserved."""
    from ...study.store import BEYOND, Store

    options = WithdrawOptions.of(said)
    code = options.code
    folder, design = store_of(options.study, options.data)
    with Store(folder, study=None if design is None else design.name, say=typer.echo) as opened:
        if not opened.finish_withdrawal(code):
            if not options.yes and not sys.stdin.isatty():
                raise InputError(f"withdrawing {code} cannot be undone: use --yes, or a terminal for the confirmation")
            found = opened.holdings(code)
            typer.echo(f"Participant {found.code} in {folder}: {found.describe()}.")
            typer.echo(f"Exports call this participant {found.sub}: write it down, it is erased as well.")
            if not options.yes and not typer.confirm("Erase it for good?"):
                typer.echo("Nothing was erased.")
                return
        erased = opened.withdraw(code)
        known, amount = (code, "the rest of it") if erased is None else (erased.code, erased.describe())
    typer.echo(
        f"Participant {known} has withdrawn; erased: {amount}. The code stays marked, and their order is free. {BEYOND}"
    )
