"""One of several buttons, while it is being chosen."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ...display import Command
from .card import Card, Choices


class Picking:
    """choices: (name, text). marked: the one that is meant, None for none yet. picked: the name of the one that was, "" before.

    card: what is seen of it now, for what is pointed at.
    """

    def __init__(self, choices: Choices, marked: int | None, card: Callable[[], Card]) -> None:
        self.choices, self.marked, self.picked = choices, marked, ""
        self._card = card

    def obey(self, command: Command) -> bool:
        """Whether it was one for it."""
        does = getattr(self, f"_do_{command.control}", None)
        if does is not None and not self.picked:
            does(command.value)
        return does is not None

    def _do_left(self, _: object) -> None:
        self._step(-1)

    def _do_right(self, _: object) -> None:
        self._step(1)

    _do_up, _do_down = _do_left, _do_right

    def _step(self, steps: int) -> None:
        """Not round the end: a held key is to stop there."""
        last = len(self.choices) - 1
        first = 0 if steps > 0 else last
        self.marked = first if self.marked is None else min(max(self.marked + steps, 0), last)

    def _do_confirm(self, _: object) -> None:
        if self.marked is not None:
            self.picked = self.choices[self.marked][0]

    def _do_point(self, at: Sequence[float]) -> None:
        name = self._card().button_at(*at)
        if name:
            self.marked = [one for one, _ in self.choices].index(name)

    def _do_press(self, at: Sequence[float]) -> None:
        self.picked = self._card().button_at(*at)
