"""Groups of commands whose help shows the summary of each as a whole."""

from __future__ import annotations

from typing import Any

from typer.core import TyperGroup

_LONG = 1000  # characters: longer than any first sentence


class Group(TyperGroup):
    """A group of commands that wraps their summaries instead of cutting them."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the commands, each with its first sentence."""
        rows = [(name, self.commands[name].get_short_help_str(_LONG)) for name in self.list_commands(ctx)]
        with formatter.section("Commands"):
            formatter.write_dl(rows)
