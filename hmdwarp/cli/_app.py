"""The commands, put together."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated

import typer

from ..options import Option
from ..resources import __version__
from . import bench, check, compare, doctor, listing, live, plan, record, replay, serve, study, thesis, trace, warp
from ._help import Group
from ._options import commands

app = typer.Typer(
    name="hmdwarp",
    cls=Group,
    help="Latency compensation for head-mounted displays: warps late RGB-D frames to the newest head pose.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"hmdwarp {__version__}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> None:
    """Latency compensation for head-mounted displays."""


app.command("replay")(replay.replay)
app.command("live")(live.live)
app.command("record")(record.record)
app.command("serve")(serve.serve)
app.command("bench")(bench.bench)
app.command("bench merge")(bench.merge)
app.command("compare")(compare.compare)
app.command("warp")(warp.warp)
app.command("check")(check.check)
app.command("thesis")(thesis.thesis)
app.command("list")(listing.list_)
app.command("plan")(plan.plan)
app.command("doctor")(doctor.doctor)
app.add_typer(study.app, name="study")
app.add_typer(trace.app, name="trace")


def _options_of_all(group: typer.Typer, prefix: str = "") -> Iterator[tuple[str, list[Option]]]:
    for one in group.registered_commands:
        yield f"{prefix}{one.name or one.callback.__name__}", one.callback.options  # type: ignore[union-attr]
    for inner in group.registered_groups:
        assert inner.typer_instance is not None
        yield from _options_of_all(inner.typer_instance, f"{prefix}{inner.name} ")


commands.update(_options_of_all(app))
