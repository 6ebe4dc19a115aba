"""hmdwarp diff: what differs between two replays."""

from __future__ import annotations

from pathlib import Path

import attrs
import typer

from .. import report
from ..errors import RequirementError
from ..options import Declared, force_field, option, out_field
from ..run.requirements import Tolerance, tolerance_field
from ._options import JSON, Said, as_json, command_line, takes


@attrs.frozen
class DiffOptions(Declared):
    """Two replays, and how near they have to be."""

    first: Path = option(attrs.NOTHING, "Folder of a replay, or its summary.json alone.", positional=True)
    second: Path = option(attrs.NOTHING, "Folder of another, or its summary.json.", positional=True)
    tolerance: Tolerance = tolerance_field()
    out: Path | None = out_field(None, "Folder for diff.html and diff.json.")
    force: bool = force_field()


@takes(DiffOptions, JSON)
def diff(said: Said) -> None:
    """Compare two replays: set-up, figures, refreshes and pictures, times left out.

    Ends with status 4 where they differ.
    """
    options = DiffOptions.of(said)
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
