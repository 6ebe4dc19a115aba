"""hmdwarp study recover: what can be read of a damaged store, as a new one."""

from __future__ import annotations

from pathlib import Path

import attrs
import typer

from ...options import Declared, option
from .._options import Said, takes
from ._options import origin_of, pilot_field, simulated_field, store_field, store_of, study_field


@attrs.frozen
class RecoverOptions(Declared):
    """Which store to rescue, and where to."""

    study: str = study_field()
    out: Path = option(attrs.NOTHING, "A new folder for what can be rescued.", kind=Path)
    store: Path | None = store_field()
    pilot: bool = pilot_field()
    simulated: bool = simulated_field()


@takes(RecoverOptions)
def recover(said: Said) -> None:
    """Rescue what can be read of damaged data into a new folder, and say what is lost."""
    from ...study.store import recover as run

    options = RecoverOptions.of(said)
    folder, design = store_of(options)
    origin = origin_of(options.pilot, options.simulated)
    found = run(folder, options.out, design, "" if design is None else design.name, origin)
    for line in found.describe():
        typer.echo(line)
    typer.echo(f"written: {options.out}; name it with --store, and keep {folder} as it is")
