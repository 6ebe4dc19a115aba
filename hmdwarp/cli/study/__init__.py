"""hmdwarp study: rating sessions from the plan to the paper; one file per command."""

from __future__ import annotations

import typer

from .._help import Group
from . import analyse, export, measure, merge, plan, power, predict, recover, run, withdraw

app = typer.Typer(cls=Group, help="Rating studies: plan, run, export, analyse.", no_args_is_help=True)

app.command("init")(plan.init)
app.command("plan")(plan.plan)
app.command("run")(run.run)
app.command("measure")(measure.measure)
app.command("merge")(merge.merge)
app.command("export")(export.export)
app.command("analyse")(analyse.analyse)
app.command("predict")(predict.predict)
app.command("power")(power.power)
app.command("withdraw")(withdraw.withdraw)
app.command("recover")(recover.recover)
