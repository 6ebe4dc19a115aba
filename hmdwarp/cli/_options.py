"""Options shared by commands, and how help shows options and commands."""

from __future__ import annotations

import inspect
import json
import math
import shlex
import sys
import textwrap
from collections.abc import Callable, Iterable, Mapping
from itertools import zip_longest
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup

from ..base import Declared, InputError, Option, options_of, path_of
from ..base.named_files import OUTSIDE, allow_outside

HELP_ALL = "--help-all"
_MANY = 40  # options
_LONG = 1000  # characters: longer than any first sentence
_NOT_TYPED = ("DEFAULT", "DEFAULT_MAP")
_NUMBERS: dict[type, str] = {int: "<int>", float: "<float>"}  # kinds of options, and how help calls a value


class Group(TyperGroup):
    """A group of commands that wraps their summaries instead of cutting them.

    A command may have two words, such as `bench merge` next to `bench`.
    """

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return the command that the arguments begin with, and the rest of them."""
        if " ".join(args[:2]) in self.list_commands(ctx):
            args = [" ".join(args[:2]), *args[2:]]
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the commands, each with its first sentence."""
        commands = {name: self.get_command(ctx, name) for name in self.list_commands(ctx)}
        rows = [(name, command.get_short_help_str(_LONG)) for name, command in commands.items() if command]
        with formatter.section("Commands"):
            formatter.write_dl(rows)


class Command(TyperCommand):
    """A command whose help shows its options in panels, the ones that matter first.

    Of many options it explains those alone, and names the others; --help-all explains all.
    """

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the command line."""
        ctx.meta[HELP_ALL] = HELP_ALL in args
        return super().parse_args(ctx, ["--help"] if HELP_ALL in args else args)

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write arguments, then the options of each panel."""
        panels: dict[str, list[tuple[str, str]]] = {}
        for parameter in self.get_params(ctx):
            if (row := parameter.get_help_record(ctx)) is not None:
                usual = "Arguments" if parameter.param_type_name == "argument" else "Options"
                panels.setdefault(getattr(parameter, "rich_help_panel", None) or usual, []).append(row)
        brief = not ctx.meta[HELP_ALL] and sum(map(len, panels.values())) > _MANY
        for title in sorted(panels, key=lambda name: {"Arguments": 0, "Options": 1}.get(name, 2)):
            if not brief or title in ("Arguments", "Options"):
                with formatter.section(title):
                    formatter.write_dl(panels[title])
        if brief:
            others = {title: panels[title] for title in panels if title not in ("Arguments", "Options")}
            with formatter.section(f"More options, which {HELP_ALL} explains"):
                for title, rows in others.items():
                    flags, wide = ", ".join(row[0].split()[0] for row in rows), max(map(len, others))
                    # A flag is never broken at its hyphens.
                    lines = textwrap.wrap(flags, formatter.width - wide - 4, break_on_hyphens=False)
                    for head, line in zip_longest([title], lines, fillvalue=""):
                        formatter.write(f"  {head:<{wide}}  {line}\n")


class Said(dict[str, Any]):
    """Values by the names of their options: those that were typed, and by index the defaults too.

    What was not typed is not "in" it, so that an option's own default can be told from it.
    """

    def __init__(self, typed: Mapping[str, Any], options: Iterable[Option]) -> None:
        super().__init__(typed)
        self._defaults = {option.name: option.default for option in options}

    def __missing__(self, name: str) -> Any:
        return self._defaults[name]


QUIET = Option("Print nothing but errors.", bool, False, name="quiet")
JSON = Option("Print one JSON object instead of text.", bool, False, name="json")


def takes(*declared: type[Declared] | Option) -> Callable[[Callable[[Said], None]], Callable[..., None]]:
    """Make a function a command with these options, which its attribute `options` has."""
    options = [one for part in declared for one in ([part] if isinstance(part, Option) else options_of(part))]
    options += [OUTSIDE] if any(option.names_files for option in options) else []

    def decorate(run: Callable[[Said], None]) -> Callable[..., None]:
        def command(ctx: Any, **given: Any) -> None:
            typed = [one for one in options if ctx.get_parameter_source(one.name).name not in _NOT_TYPED]
            said = Said({one.name: _read(one, given[one.name]) for one in typed}, options)
            allow_outside(OUTSIDE.name in said and said[OUTSIDE.name])
            run(said)

        context = inspect.Parameter("ctx", inspect.Parameter.KEYWORD_ONLY, annotation=typer.Context)
        parameters = [context, *map(_parameter, options)]
        command.__doc__, command.__name__ = run.__doc__, run.__name__
        command.options = options  # type: ignore[attr-defined]
        command.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
        command.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
        return command

    return decorate


def _read(option: Option, value: Any) -> Any:
    """Return what was typed. Errors: InputError for an empty text."""
    if option.kind is Path:
        return path_of(value, option.flag)
    for text in value if option.kind is list else [value]:
        if isinstance(text, str) and not text.strip() and not option.may_be_empty:
            more = "" if option.required else "; leave it out for the default"
            raise InputError(f"{option.flag} '{text}': expected {option.limits or 'a value'}{more}")
    if option.kind not in _NUMBERS:
        return value
    try:
        return option.kind(value.encode("ascii", "replace"))
    except ValueError as error:
        expected = option.limits or ("a whole number" if option.kind is int else "a number")
        raise InputError(f"{option.flag} '{value}': expected {expected}") from error


def _parameter(option: Option) -> inspect.Parameter:
    # Paths and numbers as texts: see _read.
    kind: Any = list[str] if option.kind is list else bool if option.kind is bool else str
    default = inspect.Parameter.empty if option.required else option.default
    default = str(default) if isinstance(default, Path | int | float) and option.kind is not bool else default
    words = {Path: "PATH"} | _NUMBERS
    metavar = option.flag if option.positional else option.metavar or words.get(option.kind)
    about: dict[str, Any] = {"help": option.help, "metavar": metavar, "rich_help_panel": option.heading or None}
    if default in (None, ""):  # "" as None, to tell it from an empty text that was typed
        kind, default, about["show_default"] = kind | None, None, False
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


def print_results(said: Said, data: Any, as_text: Callable[[], None], report: Path | None = None) -> None:
    """Print results as text, as JSON by --json, or not at all by --quiet; and name their page."""
    if said["json"]:
        typer.echo(as_json(data))
    elif not said["quiet"]:
        as_text()
    if report is not None and not said["quiet"]:
        typer.echo(f"report: {report}", err=said["json"])


def command_line() -> str:
    """Return what was typed, for a page or a summary."""
    return shlex.join(["hmdwarp", *sys.argv[1:]])
