"""Dialogs (menu, pages, consent, breaks, questions) and their panels, as display.TextPanel.

Equal panels look the same.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from decimal import Decimal
from typing import TYPE_CHECKING, Any, ClassVar

import attrs
import numpy as np
from numpy.typing import NDArray

from ...base import linear_from_srgb
from ...display import Command, Control, control
from ..design import Ask, open_picture
from ..line_console import Question
from ..scales import CHOICE, Scale, Stepped, number_text, range_text

if TYPE_CHECKING:
    from PIL.ImageFont import FreeTypeFont, ImageFont

# 680 pixels are 1 m in a headset (display/present.py). At 300 pixels a metre, the coarsest headset
# here, letters of 28 pixels are 12 high.
WIDTH, PAD = 680, 22
SMALL, TEXT, LARGE, HUGE = 24, 28, 32, 44  # letter heights in pixels
FULL, _DIM, GROUND = 255, 120, 36  # as bright on a screen as 255, 182 and 104 of sRGB
_LINE = 1.3  # distance between rows of text, in letter heights
_PICTURE_HIGH = 420  # most rows of a picture: more would not fit a headset's eye with title and buttons


@functools.cache
def font(px: int) -> FreeTypeFont | ImageFont:
    """Load Pillow's own font, which is always there."""
    from PIL import ImageFont

    return ImageFont.load_default(px)


@functools.lru_cache(4096)
def width_of(text: str, px: int) -> float:
    """Return the width of a line in pixels."""
    return float(font(px).getlength(text))


@functools.lru_cache(1024)
def wrapped(text: str, px: int, width: float) -> tuple[str, ...]:
    """Wrap a text into lines no wider than `width`; a longer word is cut. Line ends stay."""
    rows: list[str] = []
    for line in text.splitlines():
        row = ""
        for word in line.split():
            longer = f"{row} {word}" if row else word
            if width_of(longer, px) <= width:
                row = longer
                continue
            rows += [row] if row else []
            row = word
            while width_of(row, px) > width and len(row) > 1:
                fits = next(n for n in range(len(row) - 1, 0, -1) if n == 1 or width_of(row[:n], px) <= width)
                rows.append(row[:fits])
                row = row[fits:]
        rows.append(row)
    return tuple(rows)


def _height_of(rows: int, px: int) -> int:
    """Return the height of that many rows of text."""
    return round(rows * _LINE * px)


@functools.lru_cache(8)
def _picture_light(path: str) -> NDArray[np.uint8]:
    """Load a picture as large as a panel takes it: (h, w, 3) linear light, top row first."""
    from PIL import Image

    shown = open_picture(path)
    shown.thumbnail((WIDTH - 2 * PAD, _PICTURE_HIGH), Image.Resampling.LANCZOS)
    ground = Image.new("RGBA", shown.size, "black")
    srgb = np.asarray(Image.alpha_composite(ground, shown).convert("RGB"), np.float64) / 255
    return np.round(linear_from_srgb(srgb) * 255).astype(np.uint8)


class Canvas:
    """Drawing area of a panel; all are equally wide, so that none jumps when another follows."""

    def __init__(self, height: int) -> None:
        from PIL import Image, ImageDraw

        self._image = Image.new("L", (WIDTH, height))
        self._draw = ImageDraw.Draw(self._image)

    def text(self, x: float, y: float, text: str, px: int, ink: int = FULL, anchor: str = "la") -> None:
        """Draw one line. anchor: as in Pillow; x is at its l(eft), m(iddle) or r(ight)."""
        self._draw.text((x, y), text, ink, font(px), anchor)

    def rows(
        self, y: float, rows: tuple[str, ...], px: int, ink: int = FULL, x: float = PAD, anchor: str = "la"
    ) -> float:
        """Draw line under line. Returns where the next thing may begin."""
        for number, row in enumerate(rows):
            self.text(x, y + _height_of(number, px), row, px, ink, anchor)
        return y + _height_of(len(rows), px)

    def box(self, left: float, top: float, right: float, bottom: float, *, marked: bool) -> None:
        fill, outline, width = (GROUND, FULL, 4) if marked else (None, _DIM, 2)
        self._draw.rounded_rectangle((left, top, right, bottom), 8, fill=fill, outline=outline, width=width)

    def line(self, x: float, y: float, to_x: float, to_y: float, ink: int = FULL, width: int = 2) -> None:
        self._draw.line((x, y, to_x, to_y), ink, width)

    def pointer(self, x: float, y: float, size: float) -> None:
        self._draw.polygon(((x, y), (x - 0.6 * size, y - size), (x + 0.6 * size, y - size)), FULL)

    def ink(self) -> NDArray[np.uint8]:
        return np.asarray(self._image)


_KEYPAD = {str(digit): (f"KP {digit}",) for digit in range(10)}
_DIGITS = tuple(Control("digit", key, "", "action", also=also, value=key) for key, also in _KEYPAD.items())
_POINT = Control("digit", ".", "a number", "action", also=(",", "KP Decimal"), value=".", written="0 to 9 .")

# W A S D Q E walk. Escape opens the menu, which offers the end: a slip must not end a session, and
# the way out must be easy to find.
# In trials whose scene reacts.
_ACTING = tuple(map(control, ("push", "switch", "grab")))
# With what acts by controllers too: there the trigger does, and confirms elsewhere.
ACTING_CONTROLS: tuple[Control, ...] = (
    Control("left", "Left", "less, or the one before", "step", buttons=("left",)),
    Control("right", "Right", "more, or the next one", "step", buttons=("right",)),
    Control("up", "Up", "", "step", buttons=("up",)),
    Control("down", "Down", "", "step", buttons=("down",)),
    _POINT,
    *_DIGITS,
    Control("erase", "Backspace", "erase what was chosen", "step", also=("Delete",)),
    Control("confirm", "Enter", "confirm", "action", also=("KP Enter", "Space"), buttons=("confirm",)),
    Control("skip", "X", "cannot say", "action"),
    Control("menu", "Escape", "menu: break, stop", "action", also=("M",), buttons=("menu",)),
    *_ACTING,
    control("recentre"),
    control("full_screen"),
    attrs.evolve(control("help"), needs_text_panel=True),  # never over a trial's picture
)
CONTROLS = tuple(attrs.evolve(each, buttons=()) if each in _ACTING else each for each in ACTING_CONTROLS)


_BUTTON_HIGH = round(1.5 * LARGE)
GAP = 12

_Choices = tuple[tuple[str, str], ...]  # (name, text) of buttons


@attrs.frozen
class InputHints:
    """Names of the input that a panel mentions."""

    choose: str  # chooses a value of a scale
    pick: str  # chooses one of several buttons
    step: str  # steps only, without digits and mouse
    confirm: str
    menu: str  # opens the menu
    look: str  # how to look around, in a sentence
    skip: str = ""  # leaves a question unanswered; "" where the menu does
    mouse: bool = False  # whether there is one, so that buttons are worth drawing
    act: str = ""  # how to act in a scene that reacts
    done: str = ""  # confirms in such a scene, where `confirm` acts; "" where it does not


KEYS = InputHints(
    choose="arrows, digits or mouse",
    pick="arrows or mouse",
    step="arrows",
    confirm="Enter",
    menu="Esc",
    look="Move the mouse to look around all the time; W A S D walk.",
    skip="X",
    mouse=True,
    act="\n".join(f"{one.key} or {one.mouse} mouse button: {one.name}" for one in _ACTING),
)
CONTROLLERS = InputHints(
    choose="stick or pad",
    pick="stick or pad",
    step="stick or pad",
    confirm="trigger",
    menu="menu button",
    look="Turn your head to look around all the time.",
    act="trigger: push what the controller aims at\nsqueeze and hold: grab and move it",
    done="A or X",
)
FOLLOWING = "The view moves by itself: watch it."


def _picking_hint(hints: InputHints) -> str:
    """Return the hint under buttons."""
    return f"{hints.pick}: choose\n{hints.confirm}: confirm"


def hints_for(display: str, *, follows_trace: bool = False) -> InputHints:
    """Return the hints for a display by its name. follows_trace: a recording leads the head."""
    hints = CONTROLLERS if display == "openxr" else KEYS
    return attrs.evolve(hints, look=FOLLOWING) if follows_trace else hints


@attrs.frozen
class Button:
    """Button of a panel, in pixels, y down; all are equally high."""

    name: str  # what pressing it chooses
    text: str
    left: float
    top: float
    right: float

    @property
    def bottom(self) -> float:
        return self.top + _BUTTON_HIGH

    def draw(self, canvas: Canvas, marked: bool, dim: bool = False) -> None:
        """Draw the button. marked: the current choice. dim: for the mouse alone."""
        canvas.box(self.left, self.top, self.right, self.bottom, marked=marked)
        x, y, room = (self.left + self.right) / 2, (self.top + self.bottom) / 2, self.right - self.left - 16
        px = next((px for px in (28, 24, 20) if width_of(self.text, px) <= room), 18)
        canvas.text(x, y, self.text, px, _DIM if dim else FULL, "mm")


def row_of(choices: _Choices, top: float) -> tuple[Button, ...]:
    """Lay out buttons side by side over the whole width."""
    each = (WIDTH - 2 * PAD - GAP * (len(choices) - 1)) / max(len(choices), 1)
    return tuple(
        Button(name, text, PAD + k * (each + GAP), top, PAD + k * (each + GAP) + each)
        for k, (name, text) in enumerate(choices)
    )


def column_of(choices: _Choices, top: float) -> tuple[Button, ...]:
    """Lay out buttons one under the other."""
    down = _BUTTON_HIGH + GAP
    return tuple(Button(name, text, PAD, top + k * down, WIDTH - PAD) for k, (name, text) in enumerate(choices))


def button_at(buttons: tuple[Button, ...], x: float, y: float) -> str:
    """Return the name of the button at that place, "" for none."""
    return next((one.name for one in buttons if one.left <= x <= one.right and one.top <= y <= one.bottom), "")


def _draw_footer(canvas: Canvas, y: float, note: str, hint: str) -> None:
    """Draw the note in full ink, or else the hint, at the foot of a panel."""
    canvas.rows(y, wrapped(note or hint, SMALL, WIDTH - 2 * PAD), SMALL, FULL if note else _DIM)


def _footer_height(hint: str) -> int:
    """Return the room for the hint and for any note of two lines, so that the panel never jumps."""
    return _height_of(max(2, len(wrapped(hint, SMALL, WIDTH - 2 * PAD))), SMALL)


LEFT, RIGHT = PAD + 36.0, WIDTH - PAD - 36.0
_LABEL_APART, TICK_APART = 14, 6  # least pixels between two numbers, and between two ticks
MOST_ROWS = 3  # of an anchor's words
LISTED = 12  # most values of a list
_ROW = 40  # height of a list's row


@attrs.frozen
class _ScaleForm(Stepped):
    """The part of a scale that is drawn."""

    least: float
    most: float
    step: float
    anchors: tuple[tuple[float, str], ...] = ()  # (value, words), by value
    listed: bool = False  # whether it is a list in any case


@functools.lru_cache(32)
def layout_of(form: _ScaleForm) -> Layout:
    """Choose a line where the anchors fit, else a list, else a line with its ends named."""
    placed = None if form.listed else _placed(form)
    if placed is None and form.last < LISTED:
        return _ListLayout(form)
    if placed is None:
        ends = tuple((value, words) for value, words in form.anchors if value in (form.least, form.most))
        placed = _placed(attrs.evolve(form, anchors=ends)) or ()
    return LineLayout(form, placed)


@attrs.frozen
class _Placed:
    """Anchor of a line with its place."""

    value: float
    lines: tuple[str, ...]
    x: float  # middle of the lines
    row: int  # 0 or 1: of the two rows of anchors


def _x_of(form: _ScaleForm, value: float) -> float:
    """Return the place of a value on the line."""
    return LEFT + (RIGHT - LEFT) * (value - form.least) / (form.most - form.least)


def _placed(form: _ScaleForm) -> tuple[_Placed, ...] | None:
    """Place the anchors in one row or in two alternating ones; None where they still overlap."""
    for rows in (1, 2):
        found = [_row(form, form.anchors[first::rows], first) for first in range(rows)]
        if all(row is not None for row in found):
            return tuple(anchor for row in found for anchor in row or ())
    return None


def _row(form: _ScaleForm, anchors: tuple[tuple[float, str], ...], number: int) -> list[_Placed] | None:
    """Place each anchor within half the way to its neighbours, or up to the edge of the panel."""
    placed, xs = [], [_x_of(form, value) for value, _ in anchors]
    for k, (value, words) in enumerate(anchors):
        low = PAD if k == 0 else (xs[k - 1] + xs[k]) / 2 + 5
        high = WIDTH - PAD if k == len(xs) - 1 else (xs[k] + xs[k + 1]) / 2 - 5
        lines = wrapped(words, SMALL, min(high - low, 2.4 * SMALL * max(4, math.sqrt(len(words)))))
        cut = " ".join(lines) != " ".join(words.split())
        if len(lines) > MOST_ROWS or cut:
            return None
        half = max(width_of(line, SMALL) for line in lines) / 2 if lines else 0
        placed.append(_Placed(value, lines, min(max(xs[k], low + half), high - half), number))
    return placed


class LineLayout:
    """Line with ticks, numbers and words; the value stands large over its marker."""

    downwards = False

    def __init__(self, form: _ScaleForm, placed: tuple[_Placed, ...]) -> None:
        self._form, self._placed = form, placed
        self._line = HUGE + 34
        self._numbers = self._line + 14
        below = self._numbers + _height_of(1, SMALL) + 4
        rows = [max((len(anchor.lines) for anchor in placed if anchor.row == row), default=0) for row in (0, 1)]
        self._rows = (below, below + _height_of(rows[0], SMALL) + 4)
        self.height = self._rows[0] + sum(_height_of(count, SMALL) + 4 for count in rows if count)
        self._ticks, self._labels = _ticks(form)

    def value_at(self, x: float, y: float) -> float | None:
        """Return the value over or under that place, a little beyond the ends too."""
        if not 0 <= y <= self.height or not PAD / 2 <= x <= WIDTH - PAD / 2:
            return None
        return self._form.at(round((x - LEFT) / (RIGHT - LEFT) * self._form.last))

    def draw(self, canvas: Canvas, top: float, value: float | None, typed: str) -> None:
        """Draw the scale. value: of the marker, None for none. typed: digits shown instead."""
        y = top + self._line
        canvas.line(LEFT, y, RIGHT, y, width=3)
        for tick in self._ticks:
            x, long = _x_of(self._form, tick), tick in self._labels
            canvas.line(x, y - (9 if long else 5), x, y + (9 if long else 5), FULL if long else _DIM)
        for label in self._labels:
            canvas.text(_x_of(self._form, label), top + self._numbers, number_text(label), SMALL, _DIM, "ma")
        for anchor in self._placed:
            ink = FULL if value is None or anchor.value == value else _DIM
            canvas.rows(top + self._rows[anchor.row], anchor.lines, SMALL, ink, anchor.x, "ma")
        if value is not None:
            x, text = _x_of(self._form, value), typed or number_text(value)
            half = width_of(text, HUGE) / 2
            canvas.text(min(max(x, PAD + half), WIDTH - PAD - half), top, text, HUGE, FULL, "ma")
            canvas.pointer(x, y - 4, 24)
        elif typed:
            canvas.text(WIDTH / 2, top, f"{typed}_", HUGE, _DIM, "ma")


def _ticks(form: _ScaleForm) -> tuple[list[float], frozenset[float]]:
    """Return the values with a tick, and those with a number: round ones, as many as fit."""

    def is_round(number: float) -> bool:  # 1, 2, 2.5 or 5 times a power of ten
        return f"{number:.6e}".partition("e")[0].rstrip("0").rstrip(".") in ("1", "2", "5", "2.5")

    strides = [k for k in range(1, form.last + 1) if form.last % k == 0 and is_round(k * form.step)] or [form.last]
    apart = (RIGHT - LEFT) / form.last
    numbers = (form.least, form.most, form.least + form.step)
    widest = max(width_of(number_text(value), SMALL) for value in numbers) + _LABEL_APART
    stride = next((k for k in strides if k * apart >= widest), form.last)
    # 1, 2, 3 rather than 1, 1.5, 2
    whole = next((k for k in strides if k * form.step >= 1 - 1e-9 and k * apart >= widest), stride)
    fine = next((k for k in strides if k * apart >= TICK_APART), stride)
    values = form.values()
    return list(values[::fine]), frozenset(values[::whole])


class _ListLayout:
    """List with a row for each value: its number and its words."""

    downwards = True

    def __init__(self, form: _ScaleForm) -> None:
        self._form, self._words = form, dict(form.anchors)
        self.height = _ROW * (form.last + 1)

    def value_at(self, x: float, y: float) -> float | None:
        number = math.floor(y / _ROW)
        return self._form.values()[number] if 0 <= number <= self._form.last and 0 <= x <= WIDTH else None

    def draw(self, canvas: Canvas, top: float, value: float | None, typed: str) -> None:
        """Draw the scale, as LineLayout.draw; words that do not fit are cut."""
        for number, own in enumerate(self._form.values()):
            y, marked = top + number * _ROW, own == value
            if marked:
                canvas.box(PAD / 2, y, WIDTH - PAD / 2, y + _ROW - 2, marked=True)
            ink = FULL if marked or value is None else _DIM
            canvas.text(PAD + 44, y + _ROW / 2, number_text(own), TEXT, ink, "rm")
            first, *more = wrapped(self._words.get(own, ""), TEXT, WIDTH - 2 * PAD - 64) or ("",)
            canvas.text(PAD + 64, y + _ROW / 2, f"{first} ..." if more else first, TEXT, ink, "lm")


Layout = LineLayout | _ListLayout  # of a scale in pixels, y down from its top


SKIP, _YES, BACK = "skip", "yes", "back"
_SKIPPING = {SKIP: True, BACK: False}  # buttons that begin and end it
_TAKE_BACK = ((BACK, "back to the scale"), (_YES, "leave it unanswered"))


@attrs.frozen(cache_hash=True)
class MessagePanel:
    """Title, text and buttons: the menu, a text to read, a break, the number of a trial."""

    title: str = ""
    lines: tuple[str, ...] = ()  # of the text, already wrapped
    choices: _Choices = ()  # buttons
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

    def _titles(self) -> tuple[str, ...]:
        return wrapped(self.title, LARGE, WIDTH - 2 * PAD)

    def _text_top(self) -> int:
        return PAD // 2 + (_height_of(len(self._titles()), LARGE) + 8 if self.title else 0)

    def _text_end(self) -> int:
        if self.picture:
            return self._text_top() + int(_picture_light(self.picture).shape[0])
        return self._text_top() + _height_of(max(len(self.lines), self.least_lines), TEXT)

    def _buttons(self) -> tuple[Button, ...]:
        top, end = self._text_top(), self._text_end()
        return (column_of if self.column else row_of)(self.choices, end + (GAP if end > top else 0))

    def _foot(self) -> float:
        buttons = self._buttons()
        return buttons[-1].bottom + GAP if buttons else self._text_end()

    def height(self) -> int:
        return round(self._foot() + (_footer_height(self.hint) if self.hint or self.note else 0) + PAD // 2)

    def ink(self) -> NDArray[np.uint8]:
        """Draw the panel, (h, w), with a picture (h, w, 3); top row first."""
        canvas, top = Canvas(self.height()), self._text_top()
        canvas.rows(PAD // 2, self._titles(), LARGE)
        canvas.rows(top, self.lines, TEXT)
        for number, button in enumerate(self._buttons()):
            button.draw(canvas, marked=number == self.marked)
        _draw_footer(canvas, self._foot(), self.note, self.hint)
        if not self.picture:
            return canvas.ink()
        light, whole = _picture_light(self.picture), np.repeat(canvas.ink()[..., None], 3, axis=2)
        h, w = light.shape[:2]
        whole[top : top + h, (WIDTH - w) // 2 : (WIDTH - w) // 2 + w] = light
        return whole

    def button_at(self, u: float, v: float) -> str:
        """Return the name of the button at (u, v), origin bottom left; "" for none."""
        return button_at(self._buttons(), u * WIDTH, (1 - v) * self.height())


def message_panel(title: str, text: str = "", hint: str = "") -> MessagePanel:
    """Make a panel without buttons. text: is wrapped; its line ends stay."""
    return MessagePanel(title, wrapped(text, TEXT, WIDTH - 2 * PAD), hint=hint)


def _heading_of(ask: Ask, again: bool) -> str:
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
    form: _ScaleForm
    value: float | None = None  # where the marker is, None for nowhere
    typed: str = ""  # digits so far
    skipping: bool = False  # whether the participant is leaving it unanswered
    note: str = ""  # shown in place of the hint
    hints: InputHints = KEYS
    pointed: bool = True
    takes_text: bool = False

    def _lines(self) -> tuple[str, ...]:
        return wrapped(self.text, LARGE, WIDTH - 2 * PAD)

    def _headings(self) -> tuple[str, ...]:
        return wrapped(self.heading, SMALL, WIDTH - 2 * PAD) if self.heading else ()

    def _scale_top(self) -> int:
        head = _height_of(len(self._headings()), SMALL) if self.heading else 0
        return PAD // 2 + head + _height_of(len(self._lines()), LARGE) + 6

    def _foot(self) -> int:
        return self._scale_top() + layout_of(self.form).height + 10

    def height(self) -> int:
        buttons = row_of(_TAKE_BACK, 0)[0].bottom + GAP if self.hints.mouse or self.skipping else 0
        return round(self._foot() + buttons + _footer_height(self._hint()) + PAD // 2)

    def _hint(self) -> str:
        hints = self.hints
        if self.skipping:
            return f"{hints.confirm}: leave it unanswered\n{hints.step}: back to the scale"
        skip = f" · {hints.skip}: cannot say" if hints.skip else ""
        return f"{hints.choose}: choose\n{hints.confirm}: confirm{skip} · {hints.menu}: menu"

    def _buttons(self) -> tuple[Button, ...]:
        if self.skipping:
            return row_of(_TAKE_BACK, self._foot())
        if not self.hints.mouse:
            return ()
        whole = row_of(((SKIP, "cannot say"),), self._foot())[0]
        return (attrs.evolve(whole, left=WIDTH - PAD - 200),)

    def ink(self) -> NDArray[np.uint8]:
        """Draw the panel, (h, w), top row first."""
        canvas = Canvas(self.height())
        y = canvas.rows(PAD // 2, self._headings(), SMALL, _DIM)
        canvas.rows(y, self._lines(), LARGE)
        layout_of(self.form).draw(canvas, self._scale_top(), self.value, self.typed)
        buttons = self._buttons()
        for button in buttons:
            button.draw(canvas, marked=button.name == _YES, dim=button.name == SKIP)
        _draw_footer(canvas, buttons[0].bottom + GAP if buttons else self._foot(), self.note, self._hint())
        return canvas.ink()

    def value_at(self, u: float, v: float) -> float | None:
        """Return the value at (u, v), origin bottom left; None outside or without the scale."""
        x, y = u * WIDTH, (1 - v) * self.height() - self._scale_top()
        return None if self.skipping else layout_of(self.form).value_at(x, y)

    def button_at(self, u: float, v: float) -> str:
        """Return the name of the button at (u, v), "" for none."""
        return button_at(self._buttons(), u * WIDTH, (1 - v) * self.height())


# --- the dialogs

CONTINUE, BREAK, AGAIN, STOP = "continue", "break", "again", "stop"
TEXTS = {
    CONTINUE: "go on",
    BREAK: "have a break",
    AGAIN: "answer the last question again",
    SKIP: "leave this question unanswered",
    STOP: "end the session",
}
OFFERED = (CONTINUE, BREAK, AGAIN, STOP)
SURE = (("no", "no, go on"), ("yes", "yes, end it"))
_SURE_TO_REFUSE = (("no", "no, back to the text"), ("yes", "yes, end here"))

ROWS = 9  # of a page; a headset's eye cannot see more at once (display/present.py)
ON, DONE, AGREE, REFUSE = "on", "done", "agree", "refuse"
_DECLINE = "decline"  # the experimenter's REFUSE, confirmed at the console
_ON, _BACK = (ON, "next page"), (BACK, "page before")
_CONTROLS_OF_BUTTONS = frozenset({"left", "right", "up", "down", "confirm", "point", "press"})


class _ButtonPicker:
    """One of several buttons, while it is being chosen."""

    def __init__(self, choices: _Choices, marked: int | None, panel: Callable[[], MessagePanel]) -> None:
        self.choices = choices
        self.marked = marked  # the current choice, None for none yet
        self.picked = ""  # name of the confirmed choice
        self._panel = panel  # what is shown now, for the mouse

    def handle(self, command: Command) -> bool:
        """Carry out the command. Returns whether it was one for buttons."""
        if command.control not in _CONTROLS_OF_BUTTONS:
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
        self._picker = _ButtonPicker(tuple((name, TEXTS[name]) for name in self._offered), 0, self.panel)

    def panel(self) -> MessagePanel:
        hint = _picking_hint(self._hints)
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
                    self._stopping, self._picker = True, _ButtonPicker(SURE, 0, self.panel)
                elif name == "no":
                    self._open()
                else:
                    self.chosen = STOP if name == "yes" else name


class PageDialog:
    """Text or picture to look at; a text page by page."""

    LAST: ClassVar[_Choices] = ((DONE, "go on"),)
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
        choices: _Choices = (*((_BACK,) if page else ()), *(self.LAST if is_last else (_ON,)))
        self._picker = _ButtonPicker(choices, None if is_last and not self.MARKED else len(choices) - 1, self.panel)

    def panel(self) -> MessagePanel:
        pages = len(self._pages)
        return MessagePanel(
            title=f"{self._title} ({self._page + 1} of {pages})" if pages > 1 else self._title,
            lines=self._pages[self._page],
            choices=self._picker.choices,
            marked=self._picker.marked,
            hint=_picking_hint(self._hints),
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
    HELD = frozenset({AGREE, _DECLINE})
    MARKED = False

    def __init__(self, text: str, hints: InputHints = KEYS, title: str = "Before we begin") -> None:
        self.agreed = self.refused = self._refusing = False
        super().__init__(title, text, hints)

    def panel(self) -> MessagePanel:
        if not self._refusing:
            return super().panel()
        lines = ("The session ends now.", "You need not say why.")
        picker, hint = self._picker, _picking_hint(self._hints)
        return MessagePanel("End without taking part?", lines, picker.choices, picker.marked, hint)

    def _end(self, name: str) -> None:
        if name == REFUSE:
            self._refusing, self._picker = True, _ButtonPicker(_SURE_TO_REFUSE, 0, self.panel)
        elif name == "no":
            self._refusing = False
            self._turn(self._page)
        else:
            self.over, self.agreed, self.refused = True, name == AGREE, name in ("yes", _DECLINE)


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
_LEAST_LINES = 3  # so that the panel does not grow at the first ones


class TextDialog:
    """Question while it is answered in words: typed at a window, or by the experimenter."""

    value = None  # as QuestionDialog has it

    def __init__(self, ask: Ask, hints: InputHints = KEYS, again: bool = False) -> None:
        self.ask, self.text, self.over = ask, "", False
        self._hints, self._note = hints, ""
        self._heading = _heading_of(ask, again)
        self._picker = _ButtonPicker(CHOICES, 1, self.panel)

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
            least_lines=_LEAST_LINES,
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
                    self._picker = _ButtonPicker(CHOICES, 1, self.panel)

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
_NOTED_S = 5.0  # how long a note stays


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
        self._form = _ScaleForm(scale.least, scale.most, scale.step, tuple(anchors), listed=ask.item.answer == CHOICE)
        self._heading = _heading_of(ask, again)
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
        elif button in _SKIPPING:
            self._skipping = _SKIPPING[button]
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
        self._note, self._note_until_s = note, self._now_s() + _NOTED_S
