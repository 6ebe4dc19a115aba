"""hmdwarp study: rating sessions from the plan to the paper; one file for each command."""

from __future__ import annotations

import typer

from . import plan

app = typer.Typer(help="Rating studies: plan, run, export, analyse; nothing is lost.", no_args_is_help=True)
app.command("plan")(plan.plan)
