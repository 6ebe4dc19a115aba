"""hmdwarp study init: writes a plan to begin with."""

from __future__ import annotations

from pathlib import Path

import attrs
import typer

from ...options import Declared, option
from .._options import Said, takes


@attrs.frozen
class InitOptions(Declared):
    """A new plan."""

    name: str = option(attrs.NOTHING, "Name of the study; the file is NAME.toml.", positional=True, metavar="NAME")


@takes(InitOptions)
def init(said: Said) -> None:
    """Write NAME.toml, a commented plan that can be run as it is; nothing is overwritten."""
    from ...study.design import write_new_plan

    path = write_new_plan(InitOptions.of(said).name, Path())
    typer.echo(f"written: {path}; change it, then: hmdwarp study plan {path}")
