"""What a respondent is, as a session sees it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from ...display import Command
from ..design import Show, Step


class Respondent(Protocol):
    """Asked once a refresh."""

    def commands(self, step: Step, shown: Show | None, asked_s: float) -> Sequence[Command]:
        """What it does, in the words of Desk.commands. shown: what was last shown. asked_s: how long this step has been on."""


class Nobody:
    """The participant's own hands answer."""

    def commands(self, step: Step, shown: Show | None, asked_s: float) -> Sequence[Command]:
        """Nothing, ever."""
        return ()
