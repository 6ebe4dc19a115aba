"""A plate with a title, some text and buttons: the menu, what is to be read, a break, the number of a trial."""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

from .hints import GAP, Button, column_of, row_of, told, told_height
from .paper import LARGE, PAD, TEXT, WIDTH, Paper, height_of, wrapped

Choices = tuple[tuple[str, str], ...]


@attrs.frozen(cache_hash=True)
class Card:
    """As display.TextPanel. lines: of the text, as wide as they are. choices: (name, text) of its buttons. marked: the one that is meant, None
    for none yet. column: buttons one under the other, else side by side. least_lines: room for so many lines, so that a longer page
    does not make the plate jump. note: said in place of the hint."""

    title: str = ""
    lines: tuple[str, ...] = ()
    choices: Choices = ()
    marked: int | None = None
    hint: str = ""
    note: str = ""
    column: bool = False
    least_lines: int = 0

    @property
    def pointed(self) -> bool:
        """Whether there is anything to point at."""
        return bool(self.choices)

    def _text_top(self) -> int:
        return PAD // 2 + (height_of(len(self._titles()), LARGE) + 8 if self.title else 0)

    def _titles(self) -> tuple[str, ...]:
        return wrapped(self.title, LARGE, WIDTH - 2 * PAD)

    def _buttons(self) -> tuple[Button, ...]:
        rows = max(len(self.lines), self.least_lines)
        top = self._text_top() + (height_of(rows, TEXT) + GAP if rows else 0)
        return (column_of if self.column else row_of)(self.choices, top)

    def _foot(self) -> float:
        buttons = self._buttons()
        if buttons:
            return buttons[-1].bottom + GAP
        return self._text_top() + height_of(max(len(self.lines), self.least_lines), TEXT)

    def height(self) -> int:
        """In pixels."""
        return round(self._foot() + (told_height(self.hint) if self.hint or self.note else 0) + PAD // 2)

    def ink(self) -> NDArray[np.uint8]:
        """(h, w), top row first."""
        paper = Paper(self.height())
        paper.rows(PAD // 2, self._titles(), LARGE)
        paper.rows(self._text_top(), self.lines, TEXT)
        for number, button in enumerate(self._buttons()):
            button.draw(paper, marked=number == self.marked)
        told(paper, self._foot(), self.note, self.hint)
        return paper.ink()

    def button_at(self, u: float, v: float) -> str:
        """The button's name at that place of the plate, origin bottom left; "" for none."""
        x, y = u * WIDTH, (1 - v) * self.height()
        return next((button.name for button in self._buttons() if button.holds(x, y)), "")


def card(title: str, text: str = "", hint: str = "") -> Card:
    """One that is only looked at. text: wrapped; its line ends stay."""
    return Card(title, wrapped(text, TEXT, WIDTH - 2 * PAD), hint=hint)


def trial_card(trial: int, trials: int) -> Card:
    """Before a trial: its number, and nothing of what it will be. trial: 0 for the practice."""
    return card(f"Trial {trial} of {trials}" if trial else "Practice: look around, it is not rated")
