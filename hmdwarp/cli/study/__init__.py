"""hmdwarp study: rating sessions from the plan to the paper."""

import typer

from .._options import Group
from . import analyse, plan, stores

app = typer.Typer(cls=Group, help="Rating studies: plan, run, export, analyse.", no_args_is_help=True)

for command in (plan.init, plan.plan, plan.run, stores.measure, stores.export, analyse.analyse, stores.withdraw):
    app.command(command.__name__)(command)
