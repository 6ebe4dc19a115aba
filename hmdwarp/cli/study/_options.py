"""Arguments and options that several study commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

StudyArgument = Annotated[
    str, typer.Argument(metavar="STUDY", help="The study's .toml file, or the name of a shipped study, such as thesis.")
]
StoreOption = Annotated[
    Path | None,
    typer.Option("--store", help="Folder of the study's data; by default beside its file.", show_default=False),
]
PilotOption = Annotated[bool, typer.Option("--pilot", help="Pilot sessions instead of those of participants.")]
SimulatedOption = Annotated[
    bool, typer.Option("--simulated", help="Simulated sessions instead of those of participants.")
]
QuietOption = Annotated[bool, typer.Option("--quiet", help="Print nothing but errors.")]
