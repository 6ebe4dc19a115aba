"""The commands by name, each loaded when it is used."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from fnmatch import fnmatchcase
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any, ClassVar

import typer

from ..base import Option, __version__, commit
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
    "diff": ("runs", "diff"),
    "warp": ("warp", "warp"),
    "check": ("check", "check"),
    "synthesise": ("check", "synthesise"),
    "thesis": ("experiments", "thesis"),
    "list": ("catalogue", "list_"),
    "plan": ("plan", "plan"),
    "choose": ("runs", "choose"),
    "doctor": ("catalogue", "doctor"),
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
            found = _load(cmd_name)
            if isinstance(found, typer.Typer):
                found.rich_markup_mode = None
                for registered in found.registered_commands:
                    registered.cls = Command
                group = self.loaded[cmd_name] = typer.main.get_group(found)
                group.name = cmd_name
            else:
                alone = typer.Typer(add_completion=False, rich_markup_mode=None)
                alone.command(cmd_name, cls=Command)(found)
                self.loaded[cmd_name] = typer.main.get_command(alone)
        return self.loaded.get(cmd_name)


app = typer.Typer(
    name="hmdwarp",
    cls=Root,
    help=HELP,
    no_args_is_help=True,
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
        if not isinstance(loaded := _load(name), typer.Typer):
            found[name] = loaded.options
            continue
        for command in loaded.registered_commands:
            run: Any = command.callback
            found[f"{name} {command.name or run.__name__}"] = run.options
    return found


def entries() -> dict[str, str]:
    """Return what to use instead of each removed command, option and value (`retired.toml`)."""
    return tomllib.loads(Path(__file__).with_name("retired.toml").read_text(encoding="utf-8"))


def instead_of(arguments: Sequence[str]) -> str | None:
    """Return one sentence on the first removed name in a command line; None where it has none."""
    words = [part for word in arguments for part in (word.split("=", 1) if word.startswith("--") else [word])]
    for key, instead in entries().items():
        if _holds(words, key.split()):
            return f"{key.removeprefix('* ')} was removed: {instead}"
    return None


def _holds(words: Sequence[str], key: Sequence[str]) -> bool:
    """Return whether the command comes first, and the option anywhere, its value right after."""
    start = next((at for at, word in enumerate(key) if word.startswith("--")), len(key))
    command, option = key[:start], key[start:]
    if len(words) < len(command) or not all(map(fnmatchcase, words, command)):
        return False
    return any(len(words) >= at + len(option) and all(map(fnmatchcase, words[at:], option)) for at in range(len(words)))
