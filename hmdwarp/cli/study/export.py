"""hmdwarp study export: tables and a BIDS data set."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ._options import PilotOption, QuietOption, SimulatedOption, StoreOption, StudyArgument


def export(
    study: StudyArgument,
    out: Annotated[Path, typer.Option("--out", help="A new folder for the tables and the BIDS data set.")],
    store: StoreOption = None,
    pilot: PilotOption = False,
    simulated: SimulatedOption = False,
    remarks: Annotated[bool, typer.Option("--remarks", help="Also remarks, which may name people.")] = False,
    all_revisions: Annotated[
        bool, typer.Option("--all-revisions", help="Also every answer that was corrected later.")
    ] = False,
    parquet: Annotated[
        bool | None,
        typer.Option(
            "--parquet/--no-parquet",
            help="Write ratings.parquet; by default where pyarrow is installed.",
            show_default=False,
        ),
    ] = None,
    quiet: QuietOption = False,
) -> None:
    """Write the ratings as CSV, TSV and Parquet, and the study as BIDS with the head motion."""
    from ...errors import InputError
    from ...study.design import load_design
    from ...study.export import ExportOptions
    from ...study.export import export as run
    from ...study.store import PERSON, PILOT, SIMULATED, Store, store_folder
    from .._show import steps

    if pilot and simulated:
        raise InputError("--pilot and --simulated: they are never mixed in one table; export one after the other")
    origin = PILOT if pilot else SIMULATED if simulated else PERSON
    design = load_design(study, checked=False)
    with Store(store_folder(design, store), study=design.name) as data:
        contents = data.contents(pilot=pilot)
    options = ExportOptions(origin=origin, remarks=remarks, revisions=all_revisions, parquet=parquet)
    with steps("recordings", quiet=quiet) as (progress, _):
        made = run(contents, design, out, options, progress)
    if not quiet:
        for line in made.notes:
            typer.echo(line)
        typer.echo(f"written: {made.folder}")
