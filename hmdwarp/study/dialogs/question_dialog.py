"""Question while it is being answered, by the participant's input, the console or a respondent."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from decimal import Decimal
from typing import Any

from ...display import Command
from ..design import Ask
from ..line_console import Question
from ..scales import CHOICE, Scale, number_text, range_text
from .dialog_panels import BACK, KEYS, SKIP, YES, InputHints, QuestionPanel, ScaleForm, heading_of, layout_of

CLOSE = 1e-6  # of a step: typed numbers are decimal, values of a scale are multiples of its step


def value_of(scale: Scale, number: float) -> float | None:
    """Return the scale's own value for a number, None if the number is not on the scale."""
    steps = (number - scale.least) / scale.step
    last = round((scale.most - scale.least) / scale.step)
    # The first test also refuses NaN.
    if not -CLOSE <= steps <= last + CLOSE or abs(steps - round(steps)) > CLOSE:
        return None
    return round(scale.least + round(steps) * scale.step, 9)


def middle(scale: Scale, *, upper: bool) -> float:
    """Return the middle value; of an even number of values the upper or lower of the two there."""
    values = scale.values()
    return values[len(values) // 2 if upper else (len(values) - 1) // 2]


def moved(scale: Scale, value: float, steps: int) -> float:
    """Return the value that many steps on, within the scale."""
    last = round((scale.most - scale.least) / scale.step)
    number = round((value - scale.least) / scale.step) + steps
    return round(scale.least + min(max(number, 0), last) * scale.step, 9)


def typed_on(scale: Scale, typed: str, character: str) -> str:
    """Return the text after one more character: "0" to "9", "." or ",".

    A digit that leads to no value starts a new number, as people expect who change their mind.
    After the point, or where no value starts so, it changes nothing: 6.25 on a scale up to 6 must
    not become 5.
    """
    character = "." if character == "," else character
    starts = _starts(scale.least, scale.most, scale.step)
    anew = () if "." in typed else (character,)
    return next((text for text in (typed + character, *anew) if text in starts), typed)


def number_of(scale: Scale, typed: str) -> float | None:
    """Return the typed value, None while it is no value of the scale."""
    try:
        return value_of(scale, float(typed))
    except ValueError:
        return None


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

    Nothing is chosen beforehand: a default would draw answers to itself. A repeated question says
    so, or the participant wonders what is different.
    """

    def __init__(self, ask: Ask, now_s: Callable[[], float], hints: InputHints = KEYS, again: bool = False) -> None:
        self.ask = ask
        self.value: float | None = None  # where the marker is, None for nowhere
        self.text = ""  # as TextDialog has it
        self.confirmed = False  # whether it is over
        self.skipped = False  # whether it is over without an answer; `value` is None then
        self._now_s, self._hints = now_s, hints
        self._scale = ask.scale.of(ask.item)
        scale = ask.scale.of(ask.item)
        anchors = sorted((float(value), words) for value, words in scale.anchors.items())
        self._form = ScaleForm(scale.least, scale.most, scale.step, tuple(anchors), listed=ask.item.answer == CHOICE)
        self._heading = heading_of(ask, again)
        self._skipping = False
        self._typed = ""
        self._note, self._note_until_s = "", 0.0

    def panel(self) -> QuestionPanel:
        """Return the panel that shows the question."""
        value = None if self._skipping else self.value
        return QuestionPanel(
            self._heading, self.ask.item.text, self._form, value, self._typed, self._skipping, self.note, self._hints
        )

    def question(self) -> Question:
        """Return the question for the console."""
        scale = self._scale
        return Question(
            self.ask.item.text, scale.least, scale.most, scale.step, self._form.anchors, self.value, scale.title
        )

    @property
    def over(self) -> bool:
        """Whether it is confirmed."""
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
                self._type(typed_on(self._scale, self._typed, str(value)))
            case "erase":  # the last digit; a marker that was not typed goes as a whole
                if not self._skipping:
                    self._type(self._typed[:-1])
                self._skipping = False
            case "point":
                self._point(value)
            case "press":
                self._press(value)
            case "confirm":
                self._confirm()
            case "skip":  # at the second command, or after a confirmation
                if self._skipping:
                    self._leave()
                self._skipping = True
            case "answer":
                self._answer(value)

    def _step(self, steps: int) -> None:
        """Move the marker; the first step puts it in the middle, or takes a skip back.

        In a list of choices, which have no middle, it puts it at the end where it comes from.
        """
        if self._skipping:
            self._skipping = False
        elif self.value is None and self._form.listed:
            self._set(self._scale.least if steps > 0 else self._scale.most)
        elif self.value is None:
            self._set(middle(self._scale, upper=steps > 0))
        else:
            self._set(moved(self._scale, self.value, steps))

    def _type(self, typed: str) -> None:
        self._typed = typed
        self.value = number_of(self._scale, typed)

    def _set(self, value: float) -> None:
        self._typed, self.value = "", value

    def _point(self, place: tuple[float, float]) -> None:
        """Move the marker to the mouse, unless a number is typed: a sleeve may push the mouse."""
        value = self.panel().value_at(*place)
        if value is not None and not self._typed:
            self._set(value)

    def _press(self, place: tuple[float, float]) -> None:
        """Confirm the value under a click, or do what its button says."""
        panel = self.panel()
        button, value = panel.button_at(*place), panel.value_at(*place)
        if button == SKIP:
            self._skipping = True
        elif button == BACK:
            self._skipping = False
        elif button == YES:
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

    def _answer(self, value: object) -> None:
        """Take a number of the scale at once; None is "cannot say"."""
        if value is None:
            self._leave()
            return
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        number = value_of(self._scale, value) if is_number else None  # type: ignore[arg-type]
        if number is None:
            self._refuse(number_text(value) if isinstance(value, float) else value)
        else:
            self._take(number)

    def _take(self, value: float) -> None:
        self._set(value)
        self._skipping, self.confirmed = False, True

    def _leave(self) -> None:
        self._typed, self.value = "", None
        self.skipped = self.confirmed = True

    def _refuse(self, answer: object) -> None:
        self._say(f"{answer} is no answer here: expected {range_text(self._scale)}")

    def _say(self, note: str) -> None:
        self._note, self._note_until_s = note, self._now_s() + NOTED_S
