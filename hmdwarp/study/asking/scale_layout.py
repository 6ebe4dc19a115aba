"""Where on a plate the values of a scale are: along a line with words under it, or, where there are too many words, one under the other."""

from __future__ import annotations

import functools
import math
from typing import Protocol

import attrs

from .entry import written
from .paper import DIM, FULL, HUGE, PAD, SMALL, TEXT, WIDTH, Paper, height_of, width_of, wrapped

LEFT, RIGHT = PAD + 36.0, WIDTH - PAD - 36.0
LABEL_APART, TICK_APART = 14, 6  # pixels between two numbers, and at least between two ticks
MOST_ROWS = 3  # of an anchor
LISTED = 12  # so many values may stand one under the other
ROW = 40


@attrs.frozen
class Form:
    """What of a scale is drawn. anchors: (value, words), by value."""

    least: float
    most: float
    step: float
    anchors: tuple[tuple[float, str], ...] = ()

    def values(self) -> list[float]:
        """From least to most."""
        return [round(self.least + k * self.step, 9) for k in range(self.last + 1)]

    @property
    def last(self) -> int:
        """Steps from least to most."""
        return round((self.most - self.least) / self.step)


class Layout(Protocol):
    """Pixels, y down from the top of the scale. height: of all of it. downwards: whether more is further down."""

    height: int
    downwards: bool

    def value_at(self, x: float, y: float) -> float | None:
        """The value that is pointed at, None for none."""

    def draw(self, paper: Paper, top: float, value: float | None, typed: str) -> None:
        """value: where the marker is; None for nowhere. typed: what stands there instead, as far as it is typed."""


@functools.lru_cache(32)
def layout_of(form: Form) -> Layout:
    """A line if the words find room under it."""
    placed = _placed(form)
    if placed is None and form.last < LISTED:
        return Listed(form)
    if placed is None:
        ends = tuple((value, words) for value, words in form.anchors if value in (form.least, form.most))
        placed = _placed(attrs.evolve(form, anchors=ends)) or ()
    return Line(form, placed)


@attrs.frozen
class Placed:
    """An anchor: value, its lines, their middle, and which row of anchors it is in."""

    value: float
    lines: tuple[str, ...]
    x: float
    row: int


def x_of(form: Form, value: float) -> float:
    """Of a value on the line."""
    return LEFT + (RIGHT - LEFT) * (value - form.least) / (form.most - form.least)


def _placed(form: Form) -> tuple[Placed, ...] | None:
    """Words under their values in one row, else in two by turns; None where they would overlap all the same."""
    for rows in (1, 2):
        found = [_row(form, form.anchors[first::rows], first) for first in range(rows)]
        if all(row is not None for row in found):
            return tuple(anchor for row in found for anchor in row or ())
    return None


def _row(form: Form, anchors: tuple[tuple[float, str], ...], number: int) -> list[Placed] | None:
    """Each as wide as half the way to its neighbours on both sides allows; at the ends as far as the plate goes."""
    placed, xs = [], [x_of(form, value) for value, _ in anchors]
    for k, (value, words) in enumerate(anchors):
        low = PAD if k == 0 else (xs[k - 1] + xs[k]) / 2 + 5
        high = WIDTH - PAD if k == len(xs) - 1 else (xs[k] + xs[k + 1]) / 2 - 5
        lines = wrapped(words, SMALL, min(high - low, 2.4 * SMALL * max(4, math.sqrt(len(words)))))
        cut = " ".join(lines) != " ".join(words.split())
        if len(lines) > MOST_ROWS or cut:
            return None
        half = max(width_of(line, SMALL) for line in lines) / 2 if lines else 0
        placed.append(Placed(value, lines, min(max(xs[k], low + half), high - half), number))
    return placed


class Line:
    """The number large over its marker, the line with its ticks, numbers, words."""

    downwards = False

    def __init__(self, form: Form, placed: tuple[Placed, ...]) -> None:
        self._form, self._placed = form, placed
        self._line = HUGE + 34
        self._numbers = self._line + 14
        below = self._numbers + height_of(1, SMALL) + 4
        rows = [max((len(one.lines) for one in placed if one.row == row), default=0) for row in (0, 1)]
        self._rows = (below, below + height_of(rows[0], SMALL) + 4)
        self.height = self._rows[0] + sum(height_of(count, SMALL) + 4 for count in rows if count)
        self._ticks, self._labels = _ticks(form)

    def value_at(self, x: float, y: float) -> float | None:
        """Anywhere over or under the line, a little beside its ends too."""
        if not 0 <= y <= self.height or not PAD / 2 <= x <= WIDTH - PAD / 2:
            return None
        steps = round((x - LEFT) / (RIGHT - LEFT) * self._form.last)
        return round(self._form.least + min(max(steps, 0), self._form.last) * self._form.step, 9)

    def draw(self, paper: Paper, top: float, value: float | None, typed: str) -> None:
        """As Layout.draw."""
        y = top + self._line
        paper.line(LEFT, y, RIGHT, y, width=3)
        for tick in self._ticks:
            x, long = x_of(self._form, tick), tick in self._labels
            paper.line(x, y - (9 if long else 5), x, y + (9 if long else 5), FULL if long else DIM)
        for label in self._labels:
            paper.text(x_of(self._form, label), top + self._numbers, written(label), SMALL, DIM, "ma")
        for one in self._placed:
            ink = FULL if value is None or one.value == value else DIM
            paper.rows(top + self._rows[one.row], one.lines, SMALL, ink, one.x, "ma")
        self._marker(paper, top, value, typed)

    def _marker(self, paper: Paper, top: float, value: float | None, typed: str) -> None:
        if value is None:
            if typed:
                paper.text(WIDTH / 2, top, f"{typed}_", HUGE, DIM, "ma")
            return
        x, text = x_of(self._form, value), typed or written(value)
        half = width_of(text, HUGE) / 2
        paper.text(min(max(x, PAD + half), WIDTH - PAD - half), top, text, HUGE, FULL, "ma")
        paper.pointer(x, top + self._line - 4, 24)


def _ticks(form: Form) -> tuple[list[float], frozenset[float]]:
    """Values with a tick, and those of them with their number: round ones that divide the scale, as many as find room."""
    strides = [k for k in range(1, form.last + 1) if form.last % k == 0 and _is_round(k * form.step)] or [form.last]
    apart = (RIGHT - LEFT) / form.last
    widest = (
        max(width_of(written(value), SMALL) for value in (form.least, form.most, form.least + form.step)) + LABEL_APART
    )
    stride = next((k for k in strides if k * apart >= widest), form.last)
    whole = next(
        (k for k in strides if k * form.step >= 1 - 1e-9 and k * apart >= widest), stride
    )  # 1, 2, 3 rather than 1, 1.5, 2
    fine = next((k for k in strides if k * apart >= TICK_APART), stride)
    values = form.values()
    return values[::fine], frozenset(values[::whole])


def _is_round(number: float) -> bool:
    """1, 2 or 5 times a power of ten, or what is left of a step such as 0.25."""
    digits = f"{number:.6e}".partition("e")[0].rstrip("0").rstrip(".")
    return digits in ("1", "2", "5", "2.5")


class Listed:
    """A row for each value: its number and its words."""

    downwards = True

    def __init__(self, form: Form) -> None:
        self._form, self._words = form, dict(form.anchors)
        self.height = ROW * (form.last + 1)

    def value_at(self, x: float, y: float) -> float | None:
        """The row's."""
        number = math.floor(y / ROW)
        return self._form.values()[number] if 0 <= number <= self._form.last and 0 <= x <= WIDTH else None

    def draw(self, paper: Paper, top: float, value: float | None, typed: str) -> None:
        """As Layout.draw."""
        for number, one in enumerate(self._form.values()):
            y, marked = top + number * ROW, one == value
            if marked:
                paper.box(PAD / 2, y, WIDTH - PAD / 2, y + ROW - 2, marked=True)
            ink = FULL if marked or value is None else DIM
            paper.text(PAD + 44, y + ROW / 2, written(one), TEXT, ink, "rm")
            paper.text(PAD + 64, y + ROW / 2, self._fitting(one), TEXT, ink, "lm")

    def _fitting(self, value: float) -> str:
        """Its words on one line, cut where there is no room for them."""
        lines = wrapped(self._words.get(value, ""), TEXT, WIDTH - 2 * PAD - 64)
        return "" if not lines else lines[0] if len(lines) == 1 else f"{lines[0]} ..."
