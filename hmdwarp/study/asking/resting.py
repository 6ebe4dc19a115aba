"""A break: so many seconds at least, then for as long as is wanted."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from ...display import Command
from .card import Card, card
from .hints import KEYS, Hints


class Resting:
    """seconds: at least; 0 for a pause that somebody asked for. over: whether it is.

    now_s: seconds, going on. It is a new plate once a second, not at each refresh.
    """

    def __init__(self, seconds: float, now_s: Callable[[], float], hints: Hints = KEYS, title: str = "A break") -> None:
        self._until_s, self._now_s, self._hints, self._title = now_s() + seconds, now_s, hints, title
        self.over = False

    @property
    def left_s(self) -> float:
        """Until it may be over."""
        return max(0.0, self._until_s - self._now_s())

    def label(self) -> Card:
        """For over the picture."""
        left = math.ceil(self.left_s)
        if left:
            minutes = f"{left // 60}:{left % 60:02d}"
            return card(
                self._title, f"Rest your eyes. It goes on in {minutes} at the earliest.", f"{self._hints.menu}: menu"
            )
        return card(self._title, f"Go on whenever you like: {self._hints.confirm}.", f"{self._hints.menu}: menu")

    def obey(self, commands: Sequence[Command]) -> None:
        """The participant goes on by "confirm", once the time is over; "continue", from the desk or a respondent, then as well."""
        for command in commands:
            if command.control in ("confirm", "continue") and self.left_s <= 0:
                self.over = True
