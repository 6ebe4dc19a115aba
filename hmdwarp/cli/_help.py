"""Groups of commands whose help shows the summary of each as a whole."""

from __future__ import annotations

from typing import Any

from typer.core import TyperGroup

_LONG = 1000  # characters: longer than any first sentence


class Group(TyperGroup):
    """A group of commands that wraps their summaries instead of cutting them.

    A command may have two words, such as `bench merge` beside `bench`.
    """

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return the command that the arguments begin with, and the rest of them."""
        if " ".join(args[:2]) in self.commands:
            args = [" ".join(args[:2]), *args[2:]]
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the commands, each with its first sentence."""
        rows = [(name, self.commands[name].get_short_help_str(_LONG)) for name in self.list_commands(ctx)]
        with formatter.section("Commands"):
            formatter.write_dl(rows)
