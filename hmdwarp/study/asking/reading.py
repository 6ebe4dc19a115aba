"""A text that is agreed to, or not, page by page."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ...display import Command
from .card import Card, Choices
from .hints import KEYS, Hints, picking_hint
from .paper import PAD, TEXT, WIDTH, wrapped
from .picking import Picking

ROWS = 9  # a page; more would be taller than an eye of a headset sees at once (display/notice.py)
ON, BACK, AGREE, REFUSE = "on", "back", "agree", "refuse"
FIRST: Choices = ((ON, "next page"),)
BETWEEN: Choices = ((BACK, "page before"), (ON, "next page"))
LAST: Choices = ((REFUSE, "I do not agree"), (AGREE, "I agree"))
LAST_OF_SEVERAL: Choices = ((BACK, "page before"), *LAST)


class Reading:
    """agreed, refused: whether it is over, and how. On the last page nothing is chosen beforehand. now_s: seconds, going on."""

    def __init__(
        self, text: str, now_s: Callable[[], float] = lambda: 0.0, hints: Hints = KEYS, title: str = "Before we begin"
    ) -> None:
        rows = wrapped(text.strip(), TEXT, WIDTH - 2 * PAD)
        self._pages = [rows[k : k + ROWS] for k in range(0, len(rows), ROWS)] or [()]
        self._hints, self._title, self._note = hints, title, ""
        self.agreed = self.refused = False
        self._turn(0)

    def _turn(self, page: int) -> None:
        self._page, several = page, len(self._pages) > 1
        if page == len(self._pages) - 1:
            self._picking = Picking(LAST_OF_SEVERAL if several else LAST, None, self.label)
        else:
            choices = BETWEEN if page else FIRST
            self._picking = Picking(choices, len(choices) - 1, self.label)

    def label(self) -> Card:
        """For over the picture."""
        pages, hint = len(self._pages), picking_hint(self._hints)
        title = f"{self._title} ({self._page + 1} of {pages})" if pages > 1 else self._title
        least = ROWS if pages > 1 else 0
        return Card(
            title,
            self._pages[self._page],
            self._picking.choices,
            self._picking.marked,
            hint,
            self._note,
            least_lines=least,
        )

    def obey(self, commands: Sequence[Command]) -> None:
        """From hands, desk and respondents; "agree" by the desk counts as the participant's word."""
        for command in commands:
            if self.agreed or self.refused:
                return
            if command.control == AGREE:
                self.agreed = True
            elif self._picking.obey(command):
                nothing = command.control == "confirm" and not self._picking.picked
                self._note = f"Choose one first: {self._hints.pick}" if nothing else ""
                self._take(self._picking.picked)

    def _take(self, name: str) -> None:
        if name in (ON, BACK):
            self._turn(self._page + (1 if name == ON else -1))
        self.agreed, self.refused = name == AGREE, name == REFUSE
