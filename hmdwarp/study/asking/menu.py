"""The participant's menu: at any moment on, a break, the last question again, or the end, without a reason."""

from __future__ import annotations

from collections.abc import Sequence

from ...display import Command
from .card import Card
from .hints import KEYS, Hints, picking_hint
from .picking import Picking

CONTINUE, BREAK, AGAIN, SKIP, STOP = "continue", "break", "again", "skip", "stop"
TEXTS = {
    CONTINUE: "go on",
    BREAK: "have a break",
    AGAIN: "answer the last question again",
    SKIP: "leave this question unanswered",
    STOP: "stop for today",
}
OFFERED = (CONTINUE, BREAK, AGAIN, STOP)
SURE = (("no", "no, go on"), ("yes", "yes, stop"))


class Menu:
    """offered: of CONTINUE, BREAK, AGAIN, SKIP and STOP, in the order they are seen. chosen: one of them, "" until then.

    Stopping is asked for twice, as the first may have been a slip; what was answered stays either way.
    """

    def __init__(self, offered: Sequence[str] = OFFERED, hints: Hints = KEYS) -> None:
        self._offered, self._hints, self.chosen = tuple(offered), hints, ""
        self._all()

    def _all(self) -> None:
        self._stopping = False
        self._picking = Picking(tuple((name, TEXTS[name]) for name in self._offered), 0, self.label)

    def label(self) -> Card:
        """For over the picture."""
        hint = picking_hint(self._hints)
        if self._stopping:
            lines = ("Your answers so far are kept.", "You need not say why.")
            return Card("Stop now?", lines, SURE, self._picking.marked, hint)
        return Card("Menu", (), self._picking.choices, self._picking.marked, hint, column=True)

    def obey(self, commands: Sequence[Command]) -> None:
        """From hands, desk and respondents; the names of the choices do at once what they say, and so goes "menu": on."""
        for command in commands:
            if self.chosen:
                return
            if command.control in self._offered:
                self.chosen = command.control
            elif command.control == "menu":
                self.chosen = CONTINUE
            elif self._picking.obey(command) and self._picking.picked:
                self._take(self._picking.picked)

    def _take(self, name: str) -> None:
        if name == STOP:
            self._stopping, self._picking = True, Picking(SURE, 0, self.label)
        elif name == "no":
            self._all()
        else:
            self.chosen = STOP if name == "yes" else name
