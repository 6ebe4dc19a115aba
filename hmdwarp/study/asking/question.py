"""A question as it is seen: what is asked, its scale, the marker, and what hands can do."""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

from .hints import GAP, KEYS, Button, Hints, row_of, told, told_height
from .paper import DIM, LARGE, PAD, SMALL, WIDTH, Paper, height_of, wrapped
from .scale_layout import Form, Layout, layout_of

SKIP, YES, BACK = "skip", "yes", "back"
TAKE_BACK = (("back", "back to the scale"), ("yes", "leave it unanswered"))


@attrs.frozen(cache_hash=True)
class QuestionPlate:
    """As display.TextPanel. It knows nothing of conditions.

    heading: small lines ("item 3 of 16"). text: the question. value: where the marker is, None for nowhere. typed: digits so far.
    skipping: whether it is being left unanswered. note: said in place of the hint.
    """

    heading: str
    text: str
    form: Form
    value: float | None = None
    typed: str = ""
    skipping: bool = False
    note: str = ""
    hints: Hints = KEYS
    pointed: bool = True

    @property
    def layout(self) -> Layout:
        """Of the scale."""
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
        """In pixels."""
        buttons = row_of(TAKE_BACK, 0)[0].bottom + GAP if self.hints.mouse or self.skipping else 0
        return round(self._foot() + buttons + told_height(self._hint()) + PAD // 2)

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
        """(h, w), top row first."""
        paper, y = Paper(self.height()), PAD // 2
        if self.heading:
            y = paper.rows(y, self._headings(), SMALL, DIM)
        paper.rows(y, self._lines(), LARGE)
        self.layout.draw(paper, self._scale_top(), self.value, self.typed)
        buttons = self._buttons()
        for button in buttons:
            button.draw(paper, marked=button.name == YES, dim=button.name == SKIP)
        told(paper, buttons[0].bottom + GAP if buttons else self._foot(), self.note, self._hint())
        return paper.ink()

    def value_at(self, u: float, v: float) -> float | None:
        """The value at that place of the plate, origin bottom left; None beside the scale and while it is covered."""
        x, y = u * WIDTH, (1 - v) * self.height() - self._scale_top()
        return None if self.skipping else self.layout.value_at(x, y)

    def button_at(self, u: float, v: float) -> str:
        """The button's name at that place, "" for none."""
        x, y = u * WIDTH, (1 - v) * self.height()
        return next((button.name for button in self._buttons() if button.holds(x, y)), "")
