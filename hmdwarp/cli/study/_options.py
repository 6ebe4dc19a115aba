"""Arguments and options that several study commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import attrs
import typer

from ...options import option

_STUDY = "The study's .toml file, or the name of a shipped study, such as thesis."
_STORE = "Folder of the study's data; by default STUDY-data beside its file."
StudyArgument = Annotated[str, typer.Argument(metavar="STUDY", help=_STUDY)]
StoreOption = Annotated[
    Path | None,
    typer.Option("--store", help=_STORE, show_default=False),
]
SimulatedOption = Annotated[
    bool, typer.Option("--simulated", help="Simulated sessions instead of those of participants.")
]
PilotOption = Annotated[bool, typer.Option("--pilot", help="Pilot sessions instead of those of participants.")]
QuietOption = Annotated[bool, typer.Option("--quiet", help="Print nothing but errors.")]


def study_field() -> Any:
    """Return the field of a study, for commands that declare their options."""
    return option(attrs.NOTHING, _STUDY, positional=True, metavar="STUDY")


def store_field() -> Any:
    """Return the field of a study's folder of data."""
    return option(None, _STORE, kind=Path)
