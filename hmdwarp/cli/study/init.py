"""hmdwarp study init: writes a plan to begin with."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def init(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Name of the study; the file is NAME.toml.")],
) -> None:
    """Write NAME.toml, a commented plan that can be run as it is; nothing is overwritten."""
    from ...study.design import write_new_plan

    path = write_new_plan(name, Path())
    typer.echo(f"written: {path}; change it, then: hmdwarp study plan {path}")
