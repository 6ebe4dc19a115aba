"""hmdwarp study export: tables and a BIDS data set."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def export(
    study: Annotated[
        str, typer.Argument(metavar="STUDY", help="The study's .toml file, or the name of a shipped study.")
    ],
    out: Annotated[Path, typer.Option("--out", help="A new folder for the tables and the BIDS data set.")],
    store: Annotated[
        Path | None,
        typer.Option("--store", help="Folder of the study's data; by default beside its file.", show_default=False),
    ] = None,
    pilot: Annotated[bool, typer.Option("--pilot", help="Pilot sessions instead of those of people.")] = False,
    simulated: Annotated[
        bool, typer.Option("--simulated", help="Simulated sessions instead of those of people.")
    ] = False,
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
    quiet: Annotated[bool, typer.Option("--quiet", help="Print nothing but errors.")] = False,
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
