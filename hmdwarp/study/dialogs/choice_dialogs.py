"""Dialogs with buttons: the menu, pages to read, the consent, a break, and answers in words."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, ClassVar

from ...display import Command
from ..design import Ask
from ..line_console import Question
from .dialog_panels import (
    KEYS,
    PAD,
    TEXT,
    WIDTH,
    Choices,
    InputHints,
    MessagePanel,
    heading_of,
    message_panel,
    picking_hint,
    wrapped,
)

CONTINUE, BREAK, AGAIN, SKIP, STOP = "continue", "break", "again", "skip", "stop"
TEXTS = {
    CONTINUE: "go on",
    BREAK: "have a break",
    AGAIN: "answer the last question again",
    SKIP: "leave this question unanswered",
    STOP: "end the session",
}
OFFERED = (CONTINUE, BREAK, AGAIN, STOP)
SURE = (("no", "no, go on"), ("yes", "yes, end it"))
SURE_TO_REFUSE = (("no", "no, back to the text"), ("yes", "yes, end here"))

ROWS = 9  # of a page; a headset's eye cannot see more at once (display/present.py)
ON, BACK, DONE, AGREE, REFUSE = "on", "back", "done", "agree", "refuse"
DECLINE = "decline"  # the experimenter's REFUSE, confirmed at the console
FIRST: Choices = ((ON, "next page"),)
BETWEEN: Choices = ((BACK, "page before"), (ON, "next page"))


CONTROLS_OF_BUTTONS = frozenset({"left", "right", "up", "down", "confirm", "point", "press"})


class ButtonPicker:
    """One of several buttons, while it is being chosen."""

    def __init__(self, choices: Choices, marked: int | None, panel: Callable[[], MessagePanel]) -> None:
        self.choices = choices
        self.marked = marked  # the current choice, None for none yet
        self.picked = ""  # name of the confirmed choice
        self._panel = panel  # what is shown now, for the mouse

    def handle(self, command: Command) -> bool:
        """Carry out the command. Returns whether it was one for buttons."""
        if self.picked and command.control in CONTROLS_OF_BUTTONS:
            return True
        match command.control:
            case "left" | "up":
                self._step(-1)
            case "right" | "down":
                self._step(1)
            case "confirm":
                self.picked = "" if self.marked is None else self.choices[self.marked][0]
            case "point":
                if name := self._button_at(command.value):
                    self.marked = [choice for choice, _ in self.choices].index(name)
            case "press":
                self.picked = self._button_at(command.value)
            case _:
                return False
        return True

    def _button_at(self, place: Any) -> str:
        return self._panel().button_at(*place)

    def _step(self, steps: int) -> None:
        """Mark another button; a held key stops at the end instead of starting over.

        With none marked yet, a step goes to the button on its own side.
        """
        last = len(self.choices) - 1
        first = last if steps > 0 else 0
        self.marked = first if self.marked is None else min(max(self.marked + steps, 0), last)


class MenuDialog:
    """Participant's menu: continue, a break, the last question again, or the end without a reason.

    Stopping is asked twice, as the first may be a slip; answers are kept either way.
    """

    def __init__(self, offered: Sequence[str] = OFFERED, hints: InputHints = KEYS) -> None:
        self.chosen = ""  # one of `offered`, "" before
        self._offered, self._hints = tuple(offered), hints
        self._open()

    @property
    def over(self) -> bool:
        """Whether something is chosen."""
        return bool(self.chosen)

    def _open(self) -> None:
        self._stopping = False
        self._picker = ButtonPicker(tuple((name, TEXTS[name]) for name in self._offered), 0, self.panel)

    def panel(self) -> MessagePanel:
        """Return the panel that shows the menu."""
        hint = picking_hint(self._hints)
        if self._stopping:
            lines = ("Your answers so far are kept.", "You need not say why.")
            return MessagePanel("End the session now?", lines, SURE, self._picker.marked, hint)
        return MessagePanel("Menu", (), self._picker.choices, self._picker.marked, hint, column=True)

    def handle(self, commands: Sequence[Command]) -> None:
        """Carry out the commands; the name of a choice acts at once, and "menu" continues."""
        for command in commands:
            if self.over:
                return
            if command.control in self._offered:
                self.chosen = command.control
            elif command.control == "menu":
                self.chosen = CONTINUE
            elif self._picker.handle(command) and self._picker.picked:
                self._take(self._picker.picked)

    def _take(self, name: str) -> None:
        if name == STOP:
            self._stopping, self._picker = True, ButtonPicker(SURE, 0, self.panel)
        elif name == "no":
            self._open()
        else:
            self.chosen = STOP if name == "yes" else name


class PageDialog:
    """Text or picture to look at; a text page by page."""

    LAST: ClassVar[Choices] = ((DONE, "go on"),)
    HELD: ClassVar[frozenset[str]] = frozenset({"continue"})  # commands that end it at once

    def __init__(self, title: str, text: str = "", hints: InputHints = KEYS, picture: str = "") -> None:
        rows = wrapped(text.strip(), TEXT, WIDTH - 2 * PAD)
        self._pages = [rows[k : k + ROWS] for k in range(0, len(rows), ROWS)] or [()]
        self._hints, self._title, self._picture, self._note = hints, title, picture, ""
        self.over = False
        self._turn(0)

    def _turn(self, page: int) -> None:
        self._page, several = page, len(self._pages) > 1
        if page < len(self._pages) - 1:
            choices: Choices = BETWEEN if page else FIRST
        else:
            choices = (BETWEEN[0], *self.LAST) if several else self.LAST
        self._picker = ButtonPicker(choices, self._first(choices), self.panel)

    def _first(self, choices: Choices) -> int | None:
        """Return the number of the button that is marked beforehand."""
        return len(choices) - 1

    def panel(self) -> MessagePanel:
        """Return the panel that shows the current page."""
        pages = len(self._pages)
        return MessagePanel(
            title=f"{self._title} ({self._page + 1} of {pages})" if pages > 1 else self._title,
            lines=self._pages[self._page],
            choices=self._picker.choices,
            marked=self._picker.marked,
            hint=picking_hint(self._hints),
            note=self._note,
            least_lines=ROWS if pages > 1 else 0,
            picture=self._picture,
        )

    def handle(self, commands: Sequence[Command]) -> None:
        """Carry out the commands; one of HELD, from the console, ends it at once."""
        for command in commands:
            if self.over:
                return
            if command.control in self.HELD:
                self._end(command.control)
            elif self._picker.handle(command):
                nothing = command.control == "confirm" and not self._picker.picked
                self._note = f"Choose one first: {self._hints.pick}" if nothing else ""
                if self._picker.picked:
                    self._take(self._picker.picked)

    def _take(self, name: str) -> None:
        if name in (ON, BACK):
            self._turn(self._page + (1 if name == ON else -1))
        else:
            self._end(name)

    def _end(self, name: str) -> None:
        self.over = True


class ConsentDialog(PageDialog):
    """Text that the participant agrees to or refuses, page by page.

    On the last page nothing is chosen beforehand. Refusing is confirmed once, as it ends the
    session and may be a slip. "agree" and "decline" from the console count as the participant's
    word.
    """

    LAST = ((REFUSE, "I do not agree"), (AGREE, "I agree"))
    HELD = frozenset({AGREE, DECLINE})

    def __init__(self, text: str, hints: InputHints = KEYS, title: str = "Before we begin") -> None:
        self.agreed = self.refused = False
        super().__init__(title, text, hints)

    def _turn(self, page: int) -> None:
        self._refusing = False
        super()._turn(page)

    def _first(self, choices: Choices) -> int | None:
        return None if AGREE in dict(choices) else super()._first(choices)

    def panel(self) -> MessagePanel:
        """Return the panel that shows the current page, or that has a refusal confirmed."""
        if self._refusing:
            lines = ("The session ends now.", "You need not say why.")
            return MessagePanel(
                "End without taking part?", lines, self._picker.choices, self._picker.marked, picking_hint(self._hints)
            )
        return super().panel()

    def _take(self, name: str) -> None:
        if name == REFUSE:
            self._refusing, self._picker = True, ButtonPicker(SURE_TO_REFUSE, 0, self.panel)
        elif name == "no":
            self._turn(self._page)
        else:
            super()._take(name)

    def _end(self, name: str) -> None:
        super()._end(name)
        self.agreed, self.refused = name == AGREE, name in ("yes", DECLINE)


class BreakDialog:
    """Break of at least `seconds`, then for as long as the participant likes.

    The panel changes once a second, not at each refresh.
    """

    def __init__(
        self, seconds: float, now_s: Callable[[], float], hints: InputHints = KEYS, title: str = "A break"
    ) -> None:
        self._until_s, self._now_s, self._hints, self._title = now_s() + seconds, now_s, hints, title
        self.over = False

    @property
    def left_s(self) -> float:
        """Seconds until it may be over."""
        return max(0.0, self._until_s - self._now_s())

    def panel(self) -> MessagePanel:
        """Return the panel that shows the time left."""
        left = math.ceil(self.left_s)
        text = (
            f"Rest your eyes. It goes on in {left // 60}:{left % 60:02d} at the earliest."
            if left
            else f"Go on whenever you like: {self._hints.confirm}."
        )
        return message_panel(self._title, text, f"{self._hints.menu}: menu")

    def handle(self, commands: Sequence[Command]) -> None:
        """End the break by "confirm" or "continue", once its time is over."""
        for command in commands:
            if command.control in ("confirm", "continue") and self.left_s <= 0:
                self.over = True


MOST_LETTERS = 400  # what a panel shows at once
NONE = "none"
CHOICES = ((NONE, "no answer"), (DONE, "done"))
LEAST_LINES = 3  # so that the panel does not grow at the first ones


class TextDialog:
    """Question while it is answered in words: typed at a window, or by the experimenter."""

    value = None  # as QuestionDialog has it

    def __init__(self, ask: Ask, hints: InputHints = KEYS, again: bool = False) -> None:
        self.ask, self.text, self.over = ask, "", False
        self._hints, self._note = hints, ""
        self._heading = heading_of(ask, again)
        self._picker = ButtonPicker(CHOICES, 1, self.panel)

    def panel(self) -> MessagePanel:
        """Return the panel that shows the question and the words so far."""
        typed = self._hints.mouse
        shown = f"{self.text}_" if typed else self.text or "Say it aloud; the experimenter types it."
        return MessagePanel(
            title=f"{self._heading}\n{self.ask.item.text}",
            lines=wrapped(shown, TEXT, WIDTH - 2 * PAD),
            choices=CHOICES,
            marked=self._picker.marked,
            hint=f"{'keyboard: type · ' if typed else ''}{self._hints.confirm}: confirm · {self._hints.menu}: menu",
            note=self._note,
            least_lines=LEAST_LINES,
            takes_text=typed,
        )

    def question(self) -> Question:
        """Return the question for the console."""
        return Question(
            self.ask.item.text, 0, 0, 1, entered=self.text or None, scale=self.ask.scale.title, in_words=True
        )

    def handle(self, commands: Sequence[Command]) -> None:
        """Carry out the commands; "answer" has all the words, or None for no answer."""
        for command in commands:
            if self.over:
                return
            self._note = ""
            if command.control == "type":
                self._set(self.text + str(command.value))
            elif command.control == "erase":
                self._set(self.text[:-1])
            elif command.control == "answer":
                self._set(str(command.value or ""))
                self.over = True
            elif self._picker.handle(command) and self._picker.picked:
                self._take(self._picker.picked)

    def _set(self, text: str) -> None:
        plain = "".join(letter for letter in text if letter.isprintable())
        if len(plain) > MOST_LETTERS:
            self._note = f"{MOST_LETTERS} letters at most"
        self.text = plain[:MOST_LETTERS]

    def _take(self, name: str) -> None:
        if name == NONE:
            self.text, self.over = "", True
        elif self.text.strip():
            self.text, self.over = self.text.strip(), True
        else:
            self._note = 'Answer first, or choose "no answer"'
            self._picker = ButtonPicker(CHOICES, 1, self.panel)
