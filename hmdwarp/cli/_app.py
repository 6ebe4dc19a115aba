"""The commands by name, each loaded when it is used."""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from typing import Annotated, Any, ClassVar

import typer

from ..options import Option
from ..resources import __version__, commit
from ._options import Command, Group

HELP = "Latency compensation for head-mounted displays: warps late RGB-D frames to the newest head pose."
# Command or group -> module in this package, and function or typer application there.
COMMANDS = {
    "replay": ("runs", "replay"),
    "live": ("runs", "live"),
    "record": ("runs", "record"),
    "serve": ("runs", "serve"),
    "proxy": ("runs", "proxy"),
    "bench": ("experiments", "bench"),
    "bench merge": ("experiments", "merge"),
    "compare": ("experiments", "compare"),
    "diff": ("diff", "diff"),
    "warp": ("warp", "warp"),
    "check": ("check", "check"),
    "thesis": ("experiments", "thesis"),
    "list": ("listing", "list_"),
    "plan": ("plan", "plan"),
    "choose": ("runs", "choose"),
    "doctor": ("doctor", "doctor"),
    "study": ("study", "app"),
    "trace": ("trace", "app"),
    "headset": ("headset", "app"),
}


def _load(name: str) -> Any:
    module, attribute = COMMANDS[name]
    return getattr(import_module(f".{module}", __package__), attribute)


class Root(Group):
    """The group of all commands: one that runs loads no other."""

    loaded: ClassVar[dict[str, Any]] = {}

    def __init__(self, **about: Any) -> None:
        super().__init__(**about)
        # Names, for what an unknown one may mean.
        self.commands = dict.fromkeys(COMMANDS)  # type: ignore[assignment]

    def list_commands(self, ctx: Any) -> list[str]:
        """Return all names, in the order of help."""
        return list(COMMANDS)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return a command or group, loaded at its first use; None for an unknown name."""
        if cmd_name in COMMANDS and cmd_name not in self.loaded:
            self.loaded[cmd_name] = _command_of(cmd_name)
        return self.loaded.get(cmd_name)


def _command_of(name: str) -> Any:
    loaded = _load(name)
    if isinstance(loaded, typer.Typer):
        loaded.rich_markup_mode = None
        for registered in loaded.registered_commands:
            registered.cls = Command
        command = typer.main.get_group(loaded)
        command.name = name
        return command
    alone = typer.Typer(add_completion=False, rich_markup_mode=None)
    alone.command(name, cls=Command)(loaded)
    return typer.main.get_command(alone)


app = typer.Typer(
    name="hmdwarp",
    cls=Root,
    help=HELP,
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _version(wanted: bool) -> None:
    if wanted:
        typer.echo(" ".join(filter(None, ("hmdwarp", __version__, commit()))))
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show version and commit, and exit.")
    ] = False,
) -> None:
    """Latency compensation for head-mounted displays."""


def options_of_commands() -> dict[str, list[Option]]:
    """Return the options of every command, by its whole name. Loads them all."""
    found: dict[str, list[Option]] = {}
    for name in COMMANDS:
        loaded = _load(name)
        found.update(
            _options_of_group(loaded, f"{name} ") if isinstance(loaded, typer.Typer) else [(name, loaded.options)]
        )
    return found


def _options_of_group(group: typer.Typer, prefix: str) -> Iterator[tuple[str, list[Option]]]:
    for command in group.registered_commands:
        yield f"{prefix}{command.name or command.callback.__name__}", command.callback.options  # type: ignore[union-attr]
