"""Respondent as a session sees it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from ...display import Command
from ..design import Show, Step


class Respondent(Protocol):
    """Source of commands besides the participant's own input."""

    def commands(self, step: Step, shown: Show | None, elapsed_s: float) -> Sequence[Command]:
        """Return what the respondent does at this refresh, in the words of Console.commands.

        shown: the step shown last. elapsed_s: time since this step began.
        """


class NoRespondent:
    """Respondent that never answers; the participant does."""

    def commands(self, step: Step, shown: Show | None, elapsed_s: float) -> Sequence[Command]:
        """Return nothing."""
        return ()
