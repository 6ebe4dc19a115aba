"""Question that is answered in words."""

from __future__ import annotations

from collections.abc import Sequence

from ...display import Command
from ..console import Question
from ..design import Ask
from .buttons import KEYS, InputHints
from .canvas import PAD, TEXT, WIDTH, wrapped
from .choice_dialogs import ButtonPicker
from .dialog_panels import MessagePanel, heading_of

MOST_LETTERS = 400  # what a panel shows at once
NONE, DONE = "none", "done"
CHOICES = ((NONE, "no answer"), (DONE, "done"))
ROOM = 3  # lines, so that the panel does not grow at the first ones


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
            least_lines=ROOM,
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
