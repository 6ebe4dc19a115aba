"""One question while it is being answered: what hands and desk say to it, and what is seen of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ...display import Command
from ..design import Ask
from ..desk import Question
from .entry import middle, moved, number_of, on_scale, range_in_words, typed_on, written
from .hints import KEYS, Hints
from .question import BACK, SKIP, YES, QuestionPlate
from .scale_layout import Form, layout_of

NOTED_S = 5.0  # how long a note stays


class Asked:
    """value: where the marker is, None for nowhere: nothing is chosen beforehand, which would draw answers to itself. confirmed: whether
    it is over; skipped: without an answer, then `value` is None. note: what was wrong with the last command, "" for nothing.

    now_s: seconds, going on; for how long a note stays. hints: what hands there are. again: whether it was answered before, which is said:
    who is asked the same a second time wonders what is different.
    """

    def __init__(self, ask: Ask, now_s: Callable[[], float], hints: Hints = KEYS, again: bool = False) -> None:
        self.ask = ask
        self._now_s, self._hints, self._scale = now_s, hints, ask.scale
        self._form = form_of(ask)
        self._heading = heading_of(ask, again)
        self.value: float | None = None
        self.confirmed = self.skipped = self._skipping = False
        self._typed = self._note = ""
        self._noted_s = 0.0

    # --- what is seen ---

    def label(self) -> QuestionPlate:
        """For over the picture."""
        value = None if self._skipping else self.value
        return QuestionPlate(
            self._heading, self.ask.item.text, self._form, value, self._typed, self._skipping, self.note, self._hints
        )

    def question(self) -> Question:
        """For the desk."""
        scale = self._scale
        return Question(self.ask.item.text, scale.least, scale.most, scale.step, self._form.anchors, self.value)

    @property
    def note(self) -> str:
        """What was wrong with the last command, for some seconds."""
        return self._note if self._now_s() - self._noted_s < NOTED_S else ""

    # --- what is said to it ---

    def obey(self, commands: Sequence[Command]) -> None:
        """From hands, desk and respondents, in their words. What is not its own does nothing, nor does anything after the confirmation."""
        for command in commands:
            does = getattr(self, f"_do_{command.control}", None)
            if does is not None and not self.confirmed:
                self._note = ""
                does(command.value)

    def _do_left(self, _: object) -> None:
        self._step(-1)

    def _do_right(self, _: object) -> None:
        self._step(1)

    def _do_up(self, _: object) -> None:
        self._step(-1 if layout_of(self._form).downwards else 1)

    def _do_down(self, _: object) -> None:
        self._step(1 if layout_of(self._form).downwards else -1)

    def _step(self, steps: int) -> None:
        """The first puts the marker in the middle; while it is being left unanswered, back to the scale alone."""
        if self._skipping:
            self._skipping = False
            return
        self._set(middle(self._scale, upper=steps > 0) if self.value is None else moved(self._scale, self.value, steps))

    def _do_digit(self, value: object) -> None:
        self._skipping = False
        self._type(typed_on(self._scale, self._typed, str(value)))

    def _do_erase(self, _: object) -> None:
        """The last digit; a marker that was put otherwise goes as a whole."""
        if self._skipping:
            self._skipping = False
        else:
            self._type(self._typed[:-1])

    def _type(self, typed: str) -> None:
        self._typed = typed
        self.value = number_of(self._scale, typed)

    def _set(self, value: float) -> None:
        self._typed, self.value = "", value

    def _do_point(self, at: object) -> None:
        """A mouse that is pushed by a sleeve must not change what was typed; a click does."""
        value = self.label().value_at(*_place(at))
        if value is not None and not self._typed:
            self._set(value)

    def _do_press(self, at: object) -> None:
        """On the scale: that value, confirmed; on a button: what it says; beside them nothing."""
        plate, place = self.label(), _place(at)
        button, value = plate.button_at(*place), plate.value_at(*place)
        if button == SKIP:
            self._skipping = True
        elif button == BACK:
            self._skipping = False
        elif button == YES:
            self._leave()
        elif value is not None:
            self._take(value)

    def _do_confirm(self, _: object) -> None:
        if self._skipping:
            self._leave()
        elif self.value is not None:
            self._take(self.value)
        elif self._typed:
            self._say(f"{self._typed} is no answer here: wanted {range_in_words(self._scale)}")
        else:
            self._say(f"Choose an answer first: {self._hints.choose}")

    def _do_skip(self, _: object) -> None:
        """Asked for twice, or confirmed, it is left unanswered."""
        if self._skipping:
            self._leave()
        self._skipping = True

    def _do_answer(self, value: object) -> None:
        """A number of the scale, at once; None for "cannot say"."""
        if value is None:
            self._leave()
            return
        number = (
            on_scale(self._scale, value) if isinstance(value, int | float) and not isinstance(value, bool) else None
        )
        if number is None:
            shown = written(value) if isinstance(value, float) else value
            self._say(f"{shown} is no answer here: wanted {range_in_words(self._scale)}")
        else:
            self._take(number)

    def _take(self, value: float) -> None:
        self._set(value)
        self._skipping, self.confirmed = False, True

    def _leave(self) -> None:
        self._typed, self.value = "", None
        self.skipped = self.confirmed = True

    def _say(self, note: str) -> None:
        self._note, self._noted_s = note, self._now_s()


def form_of(ask: Ask) -> Form:
    """What of its scale is drawn."""
    scale = ask.scale
    return Form(
        scale.least,
        scale.most,
        scale.step,
        tuple(sorted((float(value), words) for value, words in scale.anchors.items())),
    )


def heading_of(ask: Ask, again: bool = False) -> str:
    """Which trial it is about, or which item of how many and what is asked about it."""
    items, more = ask.scale.items, ", once more" if again else ""
    if len(items) > 1:
        heading = f"{ask.scale.title}: item {items.index(ask.item) + 1} of {len(items)}{more}"
        return f"{heading}\n{ask.scale.prompt}" if ask.scale.prompt else heading
    return (f"trial {ask.trial}" if ask.trial else ask.scale.title) + more


def _place(at: object) -> tuple[float, float]:
    u, v = at  # type: ignore[misc]
    return float(u), float(v)
