"""Commands whose parameters are made from the declarations of options."""

from __future__ import annotations

import inspect
import json
import math
import shlex
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from ..options import Declared, Option, options_of, path_of
from ..options.named_files import OUTSIDE, allow_outside

Said = dict[str, Any]
QUIET = Option("Print nothing but errors.", bool, False, name="quiet")
JSON = Option("Print one JSON object instead of text.", bool, False, name="json")


def takes(*declared: type[Declared] | Option) -> Callable[[Callable[[Said], None]], Callable[..., None]]:
    """Return a decorator.

    The function becomes a command with these options, and gets their values by name. The command's
    attribute `options` has them.
    """
    options = [*_options_in(declared)]
    options += [OUTSIDE] if any(option.names_files for option in options) else []

    def decorate(run: Callable[[Said], None]) -> Callable[..., None]:
        def command(**said: Any) -> None:
            allow_outside(said.get(OUTSIDE.name, False))
            run({option.name: _read(option, said.get(option.name, option.default)) for option in options})

        parameters = [_parameter(option) for option in options]
        command.__doc__, command.__name__ = run.__doc__, run.__name__
        command.options = options  # type: ignore[attr-defined]
        command.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
        command.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
        return command

    return decorate


def _options_in(declared: Sequence[type[Declared] | Option]) -> Iterator[Option]:
    for part in declared:
        yield from [part] if isinstance(part, Option) else options_of(part)


def _read(option: Option, value: Any) -> Any:
    return path_of(value, option.flag) if option.kind is Path and value is not None else value


def _parameter(option: Option) -> inspect.Parameter:
    # Paths as texts: an empty one is no path.
    kinds: dict[Any, Any] = {list: list[str], Path: str}
    kind = kinds.get(option.kind, option.kind)
    default = inspect.Parameter.empty if option.required else option.default
    default = str(default) if isinstance(default, Path) else default
    metavar = option.flag if option.positional else option.metavar or ("PATH" if option.kind is Path else None)
    about: dict[str, Any] = {"help": option.help, "metavar": metavar, "rich_help_panel": option.heading or None}
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


def as_json(data: Any) -> str:
    """Return what `--json` prints: valid JSON, with null for what is not known (NaN)."""

    def known(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: known(one) for key, one in value.items()}
        if isinstance(value, list | tuple):
            return [known(entry) for entry in value]
        return None if isinstance(value, float) and not math.isfinite(value) else value

    return json.dumps(known(data), indent=2, ensure_ascii=False, allow_nan=False)


def command_line() -> str:
    """Return what was typed, for a page or a summary."""
    return shlex.join(["hmdwarp", *sys.argv[1:]])
