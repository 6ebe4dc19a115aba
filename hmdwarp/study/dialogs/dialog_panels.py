"""Panels that dialogs show over the picture, as display.TextPanel; equal panels look the same."""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

from ..design import Ask
from .buttons import (
    GAP,
    KEYS,
    Button,
    Choices,
    InputHints,
    button_at,
    column_of,
    draw_footer,
    footer_height,
    row_of,
)
from .canvas import DIM, LARGE, PAD, SMALL, TEXT, WIDTH, Canvas, height_of, picture_light, wrapped
from .scale_layout import Layout, ScaleForm, layout_of

SKIP, YES, BACK = "skip", "yes", "back"
TAKE_BACK = ((BACK, "back to the scale"), (YES, "leave it unanswered"))


@attrs.frozen(cache_hash=True)
class MessagePanel:
    """Title, text and buttons: the menu, a text to read, a break, the number of a trial."""

    title: str = ""
    lines: tuple[str, ...] = ()  # of the text, already wrapped
    choices: Choices = ()  # buttons
    marked: int | None = None  # the current choice, None for none yet
    hint: str = ""
    note: str = ""  # shown in place of the hint
    column: bool = False  # buttons one under the other instead of side by side
    least_lines: int = 0  # room for so many lines, so that a longer page does not make the panel jump
    picture: str = ""  # file of a picture in place of the lines, "" for none
    takes_text: bool = False

    @property
    def pointed(self) -> bool:
        """Whether there is anything to point at."""
        return bool(self.choices)

    def _text_top(self) -> int:
        return PAD // 2 + (height_of(len(self._titles()), LARGE) + 8 if self.title else 0)

    def _titles(self) -> tuple[str, ...]:
        return wrapped(self.title, LARGE, WIDTH - 2 * PAD)

    def _text_height(self) -> int:
        if self.picture:
            return int(picture_light(self.picture).shape[0])
        return height_of(max(len(self.lines), self.least_lines), TEXT)

    def _buttons(self) -> tuple[Button, ...]:
        text = self._text_height()
        return (column_of if self.column else row_of)(self.choices, self._text_top() + (text + GAP if text else 0))

    def _foot(self) -> float:
        buttons = self._buttons()
        return buttons[-1].bottom + GAP if buttons else self._text_top() + self._text_height()

    def height(self) -> int:
        """Return the height in pixels."""
        return round(self._foot() + (footer_height(self.hint) if self.hint or self.note else 0) + PAD // 2)

    def ink(self) -> NDArray[np.uint8]:
        """Draw the panel, (h, w), top row first."""
        canvas = Canvas(self.height())
        canvas.rows(PAD // 2, self._titles(), LARGE)
        canvas.rows(self._text_top(), self.lines, TEXT)
        for number, button in enumerate(self._buttons()):
            button.draw(canvas, marked=number == self.marked)
        draw_footer(canvas, self._foot(), self.note, self.hint)
        return self._with_picture(canvas.ink()) if self.picture else canvas.ink()

    def _with_picture(self, ink: NDArray[np.uint8]) -> NDArray[np.uint8]:
        light, top = picture_light(self.picture), self._text_top()
        (h, w), whole = light.shape[:2], np.repeat(ink[..., None], 3, axis=2)
        whole[top : top + h, (WIDTH - w) // 2 : (WIDTH - w) // 2 + w] = light
        return whole

    def button_at(self, u: float, v: float) -> str:
        """Return the name of the button at (u, v), origin bottom left; "" for none."""
        return button_at(self._buttons(), u * WIDTH, (1 - v) * self.height())


def message_panel(title: str, text: str = "", hint: str = "") -> MessagePanel:
    """Make a panel without buttons. text: is wrapped; its line ends stay."""
    return MessagePanel(title, wrapped(text, TEXT, WIDTH - 2 * PAD), hint=hint)


def trial_panel(trial: int, trials: int, hint: str = "", turn: str = "") -> MessagePanel:
    """Make the panel before a trial: its number, never its condition.

    trial: 0 for the practice. turn: which of its showings follows, "" for the only one.
    """
    number = f"Trial {trial} of {trials}{f': {turn}' if turn else ''}"
    title = number if trial else "Practice: look around, it is not rated"
    return message_panel(title, hint=hint)


def heading_of(ask: Ask, again: bool) -> str:
    """Return which trial the question is about, or which item of how many it is."""
    items, more = ask.scale.items, ", once more" if again else ""
    if len(items) > 1:
        heading = f"{ask.scale.title}: item {items.index(ask.item) + 1} of {len(items)}{more}"
        return f"{heading}\n{ask.scale.prompt}" if ask.scale.prompt else heading
    return (f"trial {ask.trial}" if ask.trial else ask.scale.title) + more


@attrs.frozen(cache_hash=True)
class QuestionPanel:
    """Question with its scale and marker. It knows nothing of conditions."""

    heading: str  # small lines ("item 3 of 16")
    text: str  # the question
    form: ScaleForm
    value: float | None = None  # where the marker is, None for nowhere
    typed: str = ""  # digits so far
    skipping: bool = False  # whether the participant is leaving it unanswered
    note: str = ""  # shown in place of the hint
    hints: InputHints = KEYS
    pointed: bool = True
    takes_text: bool = False

    @property
    def layout(self) -> Layout:
        """Layout of the scale."""
        return layout_of(self.form)

    def _lines(self) -> tuple[str, ...]:
        return wrapped(self.text, LARGE, WIDTH - 2 * PAD)

    def _headings(self) -> tuple[str, ...]:
        return wrapped(self.heading, SMALL, WIDTH - 2 * PAD) if self.heading else ()

    def _scale_top(self) -> int:
        head = height_of(len(self._headings()), SMALL) if self.heading else 0
        return PAD // 2 + head + height_of(len(self._lines()), LARGE) + 6

    def _foot(self) -> int:
        return self._scale_top() + self.layout.height + 10

    def height(self) -> int:
        """Return the height in pixels."""
        buttons = row_of(TAKE_BACK, 0)[0].bottom + GAP if self.hints.mouse or self.skipping else 0
        return round(self._foot() + buttons + footer_height(self._hint()) + PAD // 2)

    def _hint(self) -> str:
        hints = self.hints
        if self.skipping:
            return f"{hints.confirm}: leave it unanswered\n{hints.step}: back to the scale"
        skip = f" · {hints.skip}: cannot say" if hints.skip else ""
        return f"{hints.choose}: choose\n{hints.confirm}: confirm{skip} · {hints.menu}: menu"

    def _buttons(self) -> tuple[Button, ...]:
        if self.skipping:
            return row_of(TAKE_BACK, self._foot())
        if not self.hints.mouse:
            return ()
        whole = row_of(((SKIP, "cannot say"),), self._foot())[0]
        return (attrs.evolve(whole, left=WIDTH - PAD - 200),)

    def ink(self) -> NDArray[np.uint8]:
        """Draw the panel, (h, w), top row first."""
        canvas = Canvas(self.height())
        y = canvas.rows(PAD // 2, self._headings(), SMALL, DIM)
        canvas.rows(y, self._lines(), LARGE)
        self.layout.draw(canvas, self._scale_top(), self.value, self.typed)
        buttons = self._buttons()
        for button in buttons:
            button.draw(canvas, marked=button.name == YES, dim=button.name == SKIP)
        draw_footer(canvas, buttons[0].bottom + GAP if buttons else self._foot(), self.note, self._hint())
        return canvas.ink()

    def value_at(self, u: float, v: float) -> float | None:
        """Return the value at (u, v), origin bottom left; None outside or without the scale."""
        x, y = u * WIDTH, (1 - v) * self.height() - self._scale_top()
        return None if self.skipping else self.layout.value_at(x, y)

    def button_at(self, u: float, v: float) -> str:
        """Return the name of the button at (u, v), "" for none."""
        return button_at(self._buttons(), u * WIDTH, (1 - v) * self.height())
