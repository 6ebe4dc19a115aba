"""Commands whose parameters are made from the declarations of options."""

from __future__ import annotations

import inspect
import shlex
import sys
from collections.abc import Callable, Mapping
from typing import Annotated, Any

import attrs
import typer

from ..options import Declared, Option, options_of

Said = dict[str, Any]
QUIET = Option("Print nothing but errors.", bool, False, name="quiet")
# Options of each command as the command line has them, by its name; `_app` fills it.
commands: dict[str, list[Option]] = {}


def takes(
    *declared: type[Declared] | Option, renamed: Mapping[str, str] | None = None
) -> Callable[[Callable[[Said], None]], Callable[..., None]]:
    """Return a decorator.

    The function becomes a command with these options, and gets what was said.

    What was said: values by option name. renamed: flags that this command calls otherwise, by
    option name. The command's attribute `options` has them as the command line does.
    """
    renamed = renamed or {}
    options = [option for one in declared for option in ([one] if isinstance(one, Option) else options_of(one))]

    def decorate(run: Callable[[Said], None]) -> Callable[..., None]:
        def command(**said: Any) -> None:
            run({one.name: said.get(renamed.get(one.name, one.name), one.default) for one in options})

        called = [attrs.evolve(option, name=renamed.get(option.name, option.name)) for option in options]
        parameters = [_parameter(option) for option in called]
        command.__doc__, command.__name__ = run.__doc__, run.__name__
        command.options = called  # type: ignore[attr-defined]
        command.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
        command.__annotations__ = {one.name: one.annotation for one in parameters}
        return command

    return decorate


def _parameter(option: Option) -> inspect.Parameter:
    kind: Any = list[str] if option.kind is list else option.kind
    default = inspect.Parameter.empty if option.required else option.default
    about: dict[str, Any] = {"help": option.help, "metavar": option.metavar}
    if default in (None, ""):
        kind, about["show_default"] = (kind | None if default is None else kind), False
    info = (
        typer.Argument(**about)
        if option.positional
        else typer.Option(f"{option.flag}/{option.off}" if option.off else option.flag, **about)
    )
    return inspect.Parameter(
        option.name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=Annotated[kind, info]
    )


def command_line() -> str:
    """Return what was typed, for a page or a summary."""
    return shlex.join(["hmdwarp", *sys.argv[1:]])
