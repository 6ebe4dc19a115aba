"""Help texts: whole summaries of the commands of a group, panels of a command's options."""

from __future__ import annotations

from typing import Any

from typer.core import TyperCommand, TyperGroup

_LONG = 1000  # characters: longer than any first sentence


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
    """A command whose help shows its options in panels, the ones that matter first."""

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write arguments, then the options of each panel."""
        panels: dict[str, list[tuple[str, str]]] = {}
        for parameter in self.get_params(ctx):
            if (row := parameter.get_help_record(ctx)) is not None:
                usual = "Arguments" if parameter.param_type_name == "argument" else "Options"
                panels.setdefault(getattr(parameter, "rich_help_panel", None) or usual, []).append(row)
        for title in sorted(panels, key=lambda name: {"Arguments": 0, "Options": 1}.get(name, 2)):
            with formatter.section(title):
                formatter.write_dl(panels[title])
