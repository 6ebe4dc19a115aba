"""hmdwarp study export: tables and a BIDS data set."""

from __future__ import annotations

from pathlib import Path

import attrs
import typer

from ...options import Declared, force_field, option, out_field
from .._options import QUIET, Said, takes
from ._options import origin_of, pilot_field, simulated_field, store_field, study_field


@attrs.frozen
class ExportCommand(Declared):
    """An export."""

    study: str = study_field()
    out: Path = out_field(attrs.NOTHING, "A new folder for the tables and the BIDS data set.")
    force: bool = force_field()
    store: Path | None = store_field()
    pilot: bool = pilot_field()
    simulated: bool = simulated_field()
    remarks: bool = option(False, "Also remarks, which may name people.")
    all_revisions: bool = option(False, "Also every answer that was corrected later.")
    parquet: bool | None = option(
        None, "Write ratings.parquet; by default where pyarrow is installed.", kind=bool, off="--no-parquet"
    )


@takes(ExportCommand, QUIET)
def export(said: Said) -> None:
    """Write the ratings as CSV, TSV and Parquet, and the study as BIDS with the head motion."""
    from ...study.design import load_design
    from ...study.export import ExportOptions
    from ...study.export import export as run
    from ...study.store import Store, folder_to_read
    from .._show import steps

    wanted = ExportCommand.of(said)
    origin = origin_of(wanted.pilot, wanted.simulated)
    design = load_design(wanted.study, checked=False)
    with Store(folder_to_read(design, wanted.store, origin), study=design.name) as data:
        contents = data.contents(pilot=wanted.pilot)
    options = ExportOptions(
        origin=origin,
        remarks=wanted.remarks,
        revisions=wanted.all_revisions,
        parquet=wanted.parquet,
        force=wanted.force,
    )
    with steps("recordings", quiet=said["quiet"]) as (progress, _):
        made = run(contents, design, wanted.out, options, progress)
    if not said["quiet"]:
        for line in made.notes:
            typer.echo(line)
        typer.echo(f"written: {made.folder}")
