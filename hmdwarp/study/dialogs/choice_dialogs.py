"""Dialogs: the menu, pages to read, the consent, a break, and questions, by a value or in words."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from decimal import Decimal
from typing import Any, ClassVar

from ...display import Command
from ..design import Ask
from ..line_console import Question
from ..scales import CHOICE, Scale, number_text, range_text
from .dialog_panels import (
    KEYS,
    PAD,
    SKIPPING,
    TEXT,
    WIDTH,
    Choices,
    InputHints,
    MessagePanel,
    QuestionPanel,
    ScaleForm,
    heading_of,
    layout_of,
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
_ON, _BACK = (ON, "next page"), (BACK, "page before")
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
        if command.control not in CONTROLS_OF_BUTTONS:
            return False
        last = len(self.choices) - 1
        match command.control:
            case _ if self.picked:
                pass
            # A held key stops at the end instead of starting over; with none marked yet, a step
            # goes to the button on its own side.
            case "left" | "up":
                self.marked = 0 if self.marked is None else max(self.marked - 1, 0)
            case "right" | "down":
                self.marked = last if self.marked is None else min(self.marked + 1, last)
            case "confirm":
                self.picked = "" if self.marked is None else self.choices[self.marked][0]
            case "point":
                if name := self._panel().button_at(*command.value):  # type: ignore[misc]
                    self.marked = [choice for choice, _ in self.choices].index(name)
            case "press":
                self.picked = self._panel().button_at(*command.value)  # type: ignore[misc]
        return True


class MenuDialog:
    """Participant's menu: go on, break, last question again, or the end, asked twice."""

    def __init__(self, offered: Sequence[str] = OFFERED, hints: InputHints = KEYS) -> None:
        self.chosen = ""  # one of `offered`, "" before
        self._offered, self._hints = tuple(offered), hints
        self._open()

    @property
    def over(self) -> bool:
        return bool(self.chosen)

    def _open(self) -> None:
        self._stopping = False
        self._picker = ButtonPicker(tuple((name, TEXTS[name]) for name in self._offered), 0, self.panel)

    def panel(self) -> MessagePanel:
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
            elif self._picker.handle(command) and (name := self._picker.picked):
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
    MARKED: ClassVar[bool] = True  # whether the last page's button is marked beforehand

    def __init__(self, title: str, text: str = "", hints: InputHints = KEYS, picture: str = "") -> None:
        rows = wrapped(text.strip(), TEXT, WIDTH - 2 * PAD)
        self._pages = [rows[k : k + ROWS] for k in range(0, len(rows), ROWS)] or [()]
        self._hints, self._title, self._picture, self._note = hints, title, picture, ""
        self.over = False
        self._turn(0)

    def _turn(self, page: int) -> None:
        self._page = page
        is_last = page == len(self._pages) - 1
        choices: Choices = (*((_BACK,) if page else ()), *(self.LAST if is_last else (_ON,)))
        self._picker = ButtonPicker(choices, None if is_last and not self.MARKED else len(choices) - 1, self.panel)

    def panel(self) -> MessagePanel:
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
                if self._picker.picked in (ON, BACK):
                    self._turn(self._page + (1 if self._picker.picked == ON else -1))
                elif self._picker.picked:
                    self._end(self._picker.picked)

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
    MARKED = False

    def __init__(self, text: str, hints: InputHints = KEYS, title: str = "Before we begin") -> None:
        self.agreed = self.refused = self._refusing = False
        super().__init__(title, text, hints)

    def panel(self) -> MessagePanel:
        if not self._refusing:
            return super().panel()
        lines = ("The session ends now.", "You need not say why.")
        picker, hint = self._picker, picking_hint(self._hints)
        return MessagePanel("End without taking part?", lines, picker.choices, picker.marked, hint)

    def _end(self, name: str) -> None:
        if name == REFUSE:
            self._refusing, self._picker = True, ButtonPicker(SURE_TO_REFUSE, 0, self.panel)
        elif name == "no":
            self._refusing = False
            self._turn(self._page)
        else:
            self.over, self.agreed, self.refused = True, name == AGREE, name in ("yes", DECLINE)


class BreakDialog:
    """Break of at least `seconds`, then for as long as the participant likes."""

    def __init__(
        self, seconds: float, now_s: Callable[[], float], hints: InputHints = KEYS, title: str = "A break"
    ) -> None:
        self._until_s, self._now_s, self._hints, self._title = now_s() + seconds, now_s, hints, title
        self.over = False

    @property
    def left_s(self) -> float:
        return max(0.0, self._until_s - self._now_s())

    def panel(self) -> MessagePanel:
        """Return the panel with the time left, which changes once a second, not at each refresh."""
        left = math.ceil(self.left_s)
        rest = f"Rest your eyes. It goes on in {left // 60}:{left % 60:02d} at the earliest."
        text = rest if left else f"Go on whenever you like: {self._hints.confirm}."
        return message_panel(self._title, text, f"{self._hints.menu}: menu")

    def handle(self, commands: Sequence[Command]) -> None:
        """End the break by "confirm" or "continue", once its time is over."""
        if self.left_s <= 0 and any(command.control in ("confirm", "continue") for command in commands):
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
        text, scale = self.ask.item.text, self.ask.scale.title
        return Question(text, 0, 0, 1, entered=self.text or None, scale=scale, in_words=True)

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
                text = "" if self._picker.picked == NONE else self.text.strip()
                if text or self._picker.picked == NONE:
                    self.text, self.over = text, True
                else:
                    self._note = 'Answer first, or choose "no answer"'
                    self._picker = ButtonPicker(CHOICES, 1, self.panel)

    def _set(self, text: str) -> None:
        plain = "".join(letter for letter in text if letter.isprintable())
        if len(plain) > MOST_LETTERS:
            self._note = f"{MOST_LETTERS} letters at most"
        self.text = plain[:MOST_LETTERS]


def _typed_on(scale: Scale, typed: str, character: str) -> str:
    """Return the text after one more character: "0" to "9", "." or ",".

    A digit that leads to no value starts a new number, as people expect who change their mind.
    After the point, or where no value starts so, it changes nothing: 6.25 on a scale up to 6 must
    not become 5.
    """
    character = "." if character == "," else character
    starts = _starts(scale.least, scale.most, scale.step)
    anew = () if "." in typed else (character,)
    return next((text for text in (typed + character, *anew) if text in starts), typed)


@functools.lru_cache(16)
def _starts(least: float, most: float, step: float) -> frozenset[str]:
    """Return all beginnings of all values: "3", "3.", "3.5", "3.50"."""
    digits = max(0, *(-int(Decimal(number_text(number)).as_tuple().exponent) for number in (least, step)))
    texts = (f"{least + k * step:.{digits}f}" for k in range(round((most - least) / step) + 1))
    return frozenset(text[:n] for text in texts for n in range(1, len(text) + 1))


ACTIONS = frozenset({"left", "right", "up", "down", "digit", "erase", "point", "press", "confirm", "skip", "answer"})
NOTED_S = 5.0  # how long a note stays


class QuestionDialog:
    """Question with its answer so far.

    Nothing is chosen beforehand: a default would draw answers to itself.
    """

    def __init__(self, ask: Ask, now_s: Callable[[], float], hints: InputHints = KEYS, again: bool = False) -> None:
        self.ask = ask
        self.value: float | None = None  # where the marker is, None for nowhere
        self.text = ""  # as TextDialog has it
        self.confirmed = False  # whether it is over
        self.skipped = False  # whether it is over without an answer; `value` is None then
        self._now_s, self._hints = now_s, hints
        scale = self._scale = ask.scale.of(ask.item)
        anchors = sorted((float(value), words) for value, words in scale.anchors.items())
        self._form = ScaleForm(scale.least, scale.most, scale.step, tuple(anchors), listed=ask.item.answer == CHOICE)
        self._heading = heading_of(ask, again)
        self._skipping = False
        self._typed = ""
        self._note, self._note_until_s = "", 0.0

    def panel(self) -> QuestionPanel:
        value, text = None if self._skipping else self.value, self.ask.item.text
        shown = (self._heading, text, self._form, value, self._typed, self._skipping, self.note, self._hints)
        return QuestionPanel(*shown)

    def question(self) -> Question:
        of, text = self._scale, self.ask.item.text
        return Question(text, of.least, of.most, of.step, self._form.anchors, self.value, of.title)

    @property
    def over(self) -> bool:
        return self.confirmed

    @property
    def note(self) -> str:
        """What was wrong with the last command, "" for nothing; it goes after some seconds."""
        return self._note if self._now_s() < self._note_until_s else ""

    def handle(self, commands: Sequence[Command]) -> None:
        """Carry out the commands; unknown ones do nothing, nor does any after the confirmation."""
        for command in commands:
            if command.control in ACTIONS and not self.confirmed:
                self._note = ""
                self._carry_out(command.control, command.value)

    def _carry_out(self, control: str, value: Any) -> None:
        upwards = -1 if layout_of(self._form).downwards else 1
        match control:
            case "left" | "right":
                self._step(1 if control == "right" else -1)
            case "up" | "down":
                self._step(upwards if control == "up" else -upwards)
            case "digit":
                self._skipping = False
                self._type(_typed_on(self._scale, self._typed, str(value)))
            case "erase":  # the last digit; a marker that was not typed goes as a whole
                if not self._skipping:
                    self._type(self._typed[:-1])
                self._skipping = False
            case "point" | "press":
                self._point(value, pressed=control == "press")
            case "confirm":
                self._confirm()
            case "skip":  # at the second command, or after a confirmation
                if self._skipping:
                    self._leave()
                self._skipping = True
            case "answer":
                self._answer(value)

    def _point(self, place: tuple[float, float], *, pressed: bool) -> None:
        """Move the marker to the mouse; confirm the value under a click, or press its button."""
        panel = self.panel()
        button, value = panel.button_at(*place), panel.value_at(*place)
        if not pressed:
            if value is not None and not self._typed:  # a sleeve may push the mouse
                self.value = value
        elif button in SKIPPING:
            self._skipping = SKIPPING[button]
        elif button:
            self._leave()
        elif value is not None:
            self._take(value)

    def _confirm(self) -> None:
        if self._skipping:
            self._leave()
        elif self.value is not None:
            self._take(self.value)
        elif self._typed:
            self._refuse(self._typed)
        else:
            self._say(f"Choose an answer first: {self._hints.choose}")

    def _answer(self, value: Any) -> None:
        """Take a number of the scale at once; None is "cannot say"."""
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        number = self._scale.value_of(value) if is_number else None
        if value is None:
            self._leave()
        elif number is not None:
            self._take(number)
        else:
            self._refuse(number_text(value) if isinstance(value, float) else value)

    def _step(self, steps: int) -> None:
        """Move the marker; the first step puts it in the middle (of a list, to an end)."""
        scale = self._scale
        if self._skipping:
            self._skipping = False
            return
        self._typed = ""
        if self.value is not None:
            self.value = scale.at(round((self.value - scale.least) / scale.step) + steps)
        elif self._form.listed:
            self.value = scale.least if steps > 0 else scale.most
        else:
            self.value = scale.at((scale.last + (steps > 0)) // 2)

    def _type(self, typed: str) -> None:
        self._typed = typed
        try:
            self.value = self._scale.value_of(float(typed))
        except ValueError:  # no number yet
            self.value = None

    def _take(self, value: float) -> None:
        self._typed, self.value = "", value
        self._skipping, self.confirmed = False, True

    def _leave(self) -> None:
        self._typed, self.value = "", None
        self.skipped = self.confirmed = True

    def _refuse(self, answer: object) -> None:
        self._say(f"{answer} is no answer here: expected {range_text(self._scale)}")

    def _say(self, note: str) -> None:
        self._note, self._note_until_s = note, self._now_s() + NOTED_S
