"""Panels that dialogs show over the picture, as display.TextPanel; equal panels look the same."""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING

import attrs
import numpy as np
from numpy.typing import NDArray

from ...colour import linear_from_srgb
from ...display import Control, control
from ..design import Ask, open_picture
from ..scales import Stepped, number_text

if TYPE_CHECKING:
    from PIL.ImageFont import FreeTypeFont, ImageFont

# 680 pixels are 1 m in a headset (display/present.py). At 300 pixels a metre, the coarsest headset
# here, letters of 28 pixels are 12 high.
WIDTH, PAD = 680, 22
SMALL, TEXT, LARGE, HUGE = 24, 28, 32, 44  # letter heights in pixels
FULL, DIM, GROUND = 255, 120, 36  # as bright on a screen as 255, 182 and 104 of sRGB
LINE = 1.3  # distance between rows of text, in letter heights
PICTURE_HIGH = 420  # most rows of a picture: more would not fit a headset's eye with title and buttons


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


def height_of(rows: int, px: int) -> int:
    """Return the height of that many rows of text."""
    return round(rows * LINE * px)


@functools.lru_cache(8)
def picture_light(path: str) -> NDArray[np.uint8]:
    """Load a picture as large as a panel takes it: (h, w, 3) linear light, top row first."""
    from PIL import Image

    shown = open_picture(path)
    shown.thumbnail((WIDTH - 2 * PAD, PICTURE_HIGH), Image.Resampling.LANCZOS)
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
            self.text(x, y + height_of(number, px), row, px, ink, anchor)
        return y + height_of(len(rows), px)

    def box(self, left: float, top: float, right: float, bottom: float, *, marked: bool) -> None:
        fill, outline, width = (GROUND, FULL, 4) if marked else (None, DIM, 2)
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


BUTTON_HIGH = round(1.5 * LARGE)
GAP = 12

Choices = tuple[tuple[str, str], ...]  # (name, text) of buttons


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


def picking_hint(hints: InputHints) -> str:
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
        return self.top + BUTTON_HIGH

    def draw(self, canvas: Canvas, marked: bool, dim: bool = False) -> None:
        """Draw the button. marked: the current choice. dim: for the mouse alone."""
        canvas.box(self.left, self.top, self.right, self.bottom, marked=marked)
        x, y, room = (self.left + self.right) / 2, (self.top + self.bottom) / 2, self.right - self.left - 16
        px = next((px for px in (28, 24, 20) if width_of(self.text, px) <= room), 18)
        canvas.text(x, y, self.text, px, DIM if dim else FULL, "mm")


def row_of(choices: Choices, top: float) -> tuple[Button, ...]:
    """Lay out buttons side by side over the whole width."""
    each = (WIDTH - 2 * PAD - GAP * (len(choices) - 1)) / max(len(choices), 1)
    return tuple(
        Button(name, text, PAD + k * (each + GAP), top, PAD + k * (each + GAP) + each)
        for k, (name, text) in enumerate(choices)
    )


def column_of(choices: Choices, top: float) -> tuple[Button, ...]:
    """Lay out buttons one under the other."""
    down = BUTTON_HIGH + GAP
    return tuple(Button(name, text, PAD, top + k * down, WIDTH - PAD) for k, (name, text) in enumerate(choices))


def button_at(buttons: tuple[Button, ...], x: float, y: float) -> str:
    """Return the name of the button at that place, "" for none."""
    return next((one.name for one in buttons if one.left <= x <= one.right and one.top <= y <= one.bottom), "")


def draw_footer(canvas: Canvas, y: float, note: str, hint: str) -> None:
    """Draw the note in full ink, or else the hint, at the foot of a panel."""
    canvas.rows(y, wrapped(note or hint, SMALL, WIDTH - 2 * PAD), SMALL, FULL if note else DIM)


def footer_height(hint: str) -> int:
    """Return the room for the hint and for any note of two lines, so that the panel never jumps."""
    return height_of(max(2, len(wrapped(hint, SMALL, WIDTH - 2 * PAD))), SMALL)


LEFT, RIGHT = PAD + 36.0, WIDTH - PAD - 36.0
LABEL_APART, TICK_APART = 14, 6  # least pixels between two numbers, and between two ticks
MOST_ROWS = 3  # of an anchor's words
LISTED = 12  # most values of a list
ROW = 40  # height of a list's row


@attrs.frozen
class ScaleForm(Stepped):
    """The part of a scale that is drawn."""

    least: float
    most: float
    step: float
    anchors: tuple[tuple[float, str], ...] = ()  # (value, words), by value
    listed: bool = False  # whether it is a list in any case


@functools.lru_cache(32)
def layout_of(form: ScaleForm) -> Layout:
    """Choose a line where the anchors fit, else a list, else a line with its ends named."""
    placed = None if form.listed else _placed(form)
    if placed is None and form.last < LISTED:
        return ListLayout(form)
    if placed is None:
        ends = tuple((value, words) for value, words in form.anchors if value in (form.least, form.most))
        placed = _placed(attrs.evolve(form, anchors=ends)) or ()
    return LineLayout(form, placed)


@attrs.frozen
class Placed:
    """Anchor of a line with its place."""

    value: float
    lines: tuple[str, ...]
    x: float  # middle of the lines
    row: int  # 0 or 1: of the two rows of anchors


def x_of(form: ScaleForm, value: float) -> float:
    """Return the place of a value on the line."""
    return LEFT + (RIGHT - LEFT) * (value - form.least) / (form.most - form.least)


def _placed(form: ScaleForm) -> tuple[Placed, ...] | None:
    """Place the anchors in one row or in two alternating ones; None where they still overlap."""
    for rows in (1, 2):
        found = [_row(form, form.anchors[first::rows], first) for first in range(rows)]
        if all(row is not None for row in found):
            return tuple(anchor for row in found for anchor in row or ())
    return None


def _row(form: ScaleForm, anchors: tuple[tuple[float, str], ...], number: int) -> list[Placed] | None:
    """Place each anchor within half the way to its neighbours, or up to the edge of the panel."""
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


class LineLayout:
    """Line with ticks, numbers and words; the value stands large over its marker."""

    downwards = False

    def __init__(self, form: ScaleForm, placed: tuple[Placed, ...]) -> None:
        self._form, self._placed = form, placed
        self._line = HUGE + 34
        self._numbers = self._line + 14
        below = self._numbers + height_of(1, SMALL) + 4
        rows = [max((len(anchor.lines) for anchor in placed if anchor.row == row), default=0) for row in (0, 1)]
        self._rows = (below, below + height_of(rows[0], SMALL) + 4)
        self.height = self._rows[0] + sum(height_of(count, SMALL) + 4 for count in rows if count)
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
            x, long = x_of(self._form, tick), tick in self._labels
            canvas.line(x, y - (9 if long else 5), x, y + (9 if long else 5), FULL if long else DIM)
        for label in self._labels:
            canvas.text(x_of(self._form, label), top + self._numbers, number_text(label), SMALL, DIM, "ma")
        for anchor in self._placed:
            ink = FULL if value is None or anchor.value == value else DIM
            canvas.rows(top + self._rows[anchor.row], anchor.lines, SMALL, ink, anchor.x, "ma")
        if value is not None:
            x, text = x_of(self._form, value), typed or number_text(value)
            half = width_of(text, HUGE) / 2
            canvas.text(min(max(x, PAD + half), WIDTH - PAD - half), top, text, HUGE, FULL, "ma")
            canvas.pointer(x, y - 4, 24)
        elif typed:
            canvas.text(WIDTH / 2, top, f"{typed}_", HUGE, DIM, "ma")


def _ticks(form: ScaleForm) -> tuple[list[float], frozenset[float]]:
    """Return the values with a tick, and those with a number: round ones, as many as fit."""

    def is_round(number: float) -> bool:  # 1, 2, 2.5 or 5 times a power of ten
        return f"{number:.6e}".partition("e")[0].rstrip("0").rstrip(".") in ("1", "2", "5", "2.5")

    strides = [k for k in range(1, form.last + 1) if form.last % k == 0 and is_round(k * form.step)] or [form.last]
    apart = (RIGHT - LEFT) / form.last
    numbers = (form.least, form.most, form.least + form.step)
    widest = max(width_of(number_text(value), SMALL) for value in numbers) + LABEL_APART
    stride = next((k for k in strides if k * apart >= widest), form.last)
    # 1, 2, 3 rather than 1, 1.5, 2
    whole = next((k for k in strides if k * form.step >= 1 - 1e-9 and k * apart >= widest), stride)
    fine = next((k for k in strides if k * apart >= TICK_APART), stride)
    values = form.values()
    return list(values[::fine]), frozenset(values[::whole])


class ListLayout:
    """List with a row for each value: its number and its words."""

    downwards = True

    def __init__(self, form: ScaleForm) -> None:
        self._form, self._words = form, dict(form.anchors)
        self.height = ROW * (form.last + 1)

    def value_at(self, x: float, y: float) -> float | None:
        number = math.floor(y / ROW)
        return self._form.values()[number] if 0 <= number <= self._form.last and 0 <= x <= WIDTH else None

    def draw(self, canvas: Canvas, top: float, value: float | None, typed: str) -> None:
        """Draw the scale, as LineLayout.draw; words that do not fit are cut."""
        for number, own in enumerate(self._form.values()):
            y, marked = top + number * ROW, own == value
            if marked:
                canvas.box(PAD / 2, y, WIDTH - PAD / 2, y + ROW - 2, marked=True)
            ink = FULL if marked or value is None else DIM
            canvas.text(PAD + 44, y + ROW / 2, number_text(own), TEXT, ink, "rm")
            first, *more = wrapped(self._words.get(own, ""), TEXT, WIDTH - 2 * PAD - 64) or ("",)
            canvas.text(PAD + 64, y + ROW / 2, f"{first} ..." if more else first, TEXT, ink, "lm")


Layout = LineLayout | ListLayout  # of a scale in pixels, y down from its top


SKIP, YES, BACK = "skip", "yes", "back"
SKIPPING = {SKIP: True, BACK: False}  # buttons that begin and end it
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

    def _titles(self) -> tuple[str, ...]:
        return wrapped(self.title, LARGE, WIDTH - 2 * PAD)

    def _text_top(self) -> int:
        return PAD // 2 + (height_of(len(self._titles()), LARGE) + 8 if self.title else 0)

    def _text_end(self) -> int:
        if self.picture:
            return self._text_top() + int(picture_light(self.picture).shape[0])
        return self._text_top() + height_of(max(len(self.lines), self.least_lines), TEXT)

    def _buttons(self) -> tuple[Button, ...]:
        top, end = self._text_top(), self._text_end()
        return (column_of if self.column else row_of)(self.choices, end + (GAP if end > top else 0))

    def _foot(self) -> float:
        buttons = self._buttons()
        return buttons[-1].bottom + GAP if buttons else self._text_end()

    def height(self) -> int:
        return round(self._foot() + (footer_height(self.hint) if self.hint or self.note else 0) + PAD // 2)

    def ink(self) -> NDArray[np.uint8]:
        """Draw the panel, (h, w), with a picture (h, w, 3); top row first."""
        canvas, top = Canvas(self.height()), self._text_top()
        canvas.rows(PAD // 2, self._titles(), LARGE)
        canvas.rows(top, self.lines, TEXT)
        for number, button in enumerate(self._buttons()):
            button.draw(canvas, marked=number == self.marked)
        draw_footer(canvas, self._foot(), self.note, self.hint)
        if not self.picture:
            return canvas.ink()
        light, whole = picture_light(self.picture), np.repeat(canvas.ink()[..., None], 3, axis=2)
        h, w = light.shape[:2]
        whole[top : top + h, (WIDTH - w) // 2 : (WIDTH - w) // 2 + w] = light
        return whole

    def button_at(self, u: float, v: float) -> str:
        """Return the name of the button at (u, v), origin bottom left; "" for none."""
        return button_at(self._buttons(), u * WIDTH, (1 - v) * self.height())


def message_panel(title: str, text: str = "", hint: str = "") -> MessagePanel:
    """Make a panel without buttons. text: is wrapped; its line ends stay."""
    return MessagePanel(title, wrapped(text, TEXT, WIDTH - 2 * PAD), hint=hint)


def trial_panel(trial: int, trials: int, hint: str = "", turn: str = "") -> MessagePanel:
    """Make the panel before a trial (0: practice): its number and turn, never its condition."""
    number = f"Trial {trial} of {trials}{f': {turn}' if turn else ''}"
    return message_panel(number if trial else "Practice: look around, it is not rated", hint=hint)


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

    def _lines(self) -> tuple[str, ...]:
        return wrapped(self.text, LARGE, WIDTH - 2 * PAD)

    def _headings(self) -> tuple[str, ...]:
        return wrapped(self.heading, SMALL, WIDTH - 2 * PAD) if self.heading else ()

    def _scale_top(self) -> int:
        head = height_of(len(self._headings()), SMALL) if self.heading else 0
        return PAD // 2 + head + height_of(len(self._lines()), LARGE) + 6

    def _foot(self) -> int:
        return self._scale_top() + layout_of(self.form).height + 10

    def height(self) -> int:
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
        layout_of(self.form).draw(canvas, self._scale_top(), self.value, self.typed)
        buttons = self._buttons()
        for button in buttons:
            button.draw(canvas, marked=button.name == YES, dim=button.name == SKIP)
        draw_footer(canvas, buttons[0].bottom + GAP if buttons else self._foot(), self.note, self._hint())
        return canvas.ink()

    def value_at(self, u: float, v: float) -> float | None:
        """Return the value at (u, v), origin bottom left; None outside or without the scale."""
        x, y = u * WIDTH, (1 - v) * self.height() - self._scale_top()
        return None if self.skipping else layout_of(self.form).value_at(x, y)

    def button_at(self, u: float, v: float) -> str:
        """Return the name of the button at (u, v), "" for none."""
        return button_at(self._buttons(), u * WIDTH, (1 - v) * self.height())
