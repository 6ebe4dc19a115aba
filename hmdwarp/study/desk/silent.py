"""No desk: nobody sits there."""

from __future__ import annotations

from collections.abc import Sequence

from ...display import Command
from ._base import DeskState


class NoDesk:
    """Says nothing, asks for nothing."""

    def __enter__(self) -> NoDesk:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def tell(self, state: DeskState) -> None:
        """As Desk.tell."""

    def say(self, text: str) -> None:
        """As Desk.say."""

    def commands(self) -> Sequence[Command]:
        """As Desk.commands."""
        return ()
