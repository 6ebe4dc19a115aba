"""hmdwarp study init: writes a plan to begin with."""

from __future__ import annotations

from pathlib import Path

import attrs
import typer

from ...options import Declared, force_field, option
from .._options import Said, takes


@attrs.frozen
class InitOptions(Declared):
    """A new plan."""

    name: str = option(attrs.NOTHING, "Name of the study; the file is NAME.toml.", positional=True, metavar="NAME")
    force: bool = force_field()


@takes(InitOptions)
def init(said: Said) -> None:
    """Write NAME.toml, a commented plan that can be run as it is."""
    from ...study.design import write_new_plan

    options = InitOptions.of(said)
    path = write_new_plan(options.name, Path(), force=options.force)
    typer.echo(f"written: {path}; change it, then: hmdwarp study plan {path}")
