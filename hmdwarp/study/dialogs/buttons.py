"""Canvas that panels are drawn on, and the participant's controls with the hints of a panel.

Black ground, white ink, y down. Ink is mixed in linear light (shaders/display/picture.frag): grey
looks brighter there than in a file, and dark letters on white get thin. So a marked item gets a
frame on a slightly brighter ground, never dark letters on white.
"""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING

import attrs
import numpy as np
from numpy.typing import NDArray

from ...colour import linear_from_srgb
from ...display import Control, control
from ..design import open_picture

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
            row = _with(rows, row, word, px, width)
        rows.append(row)
    return tuple(rows)


def _with(rows: list[str], row: str, word: str, px: int, width: float) -> str:
    """Return the row with one more word; a full row goes to `rows`."""
    longer = f"{row} {word}" if row else word
    if width_of(longer, px) <= width:
        return longer
    if row:
        rows.append(row)
    while width_of(word, px) > width and len(word) > 1:
        fits = next(n for n in range(len(word) - 1, 0, -1) if n == 1 or width_of(word[:n], px) <= width)
        rows.append(word[:fits])
        word = word[fits:]
    return word


def height_of(rows: int, px: int) -> int:
    """Return the height of that many rows of text."""
    return round(rows * LINE * px)


@functools.lru_cache(8)
def picture_light(path: str) -> NDArray[np.uint8]:
    """Load a picture as large as a panel takes it: (h, w, 3) linear light, top row first.

    Errors: InputError for a file that is no picture.
    """
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
        """Draw a box with round corners."""
        at = (left, top, right, bottom)
        self._draw.rounded_rectangle(
            at, 8, fill=GROUND if marked else None, outline=FULL if marked else DIM, width=4 if marked else 2
        )

    def line(self, x: float, y: float, to_x: float, to_y: float, ink: int = FULL, width: int = 2) -> None:
        """Draw a straight line."""
        self._draw.line((x, y, to_x, to_y), ink, width)

    def pointer(self, x: float, y: float, size: float) -> None:
        """Draw a triangle that stands on its tip."""
        self._draw.polygon(((x, y), (x - 0.6 * size, y - size), (x + 0.6 * size, y - size)), FULL)

    def ink(self) -> NDArray[np.uint8]:
        """Return the picture, (h, w), top row first."""
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
    """Button of a panel, in pixels, y down."""

    name: str  # what pressing it chooses
    text: str
    left: float
    top: float
    right: float

    @property
    def bottom(self) -> float:
        """Lower edge; all buttons are equally high."""
        return self.top + BUTTON_HIGH

    def holds(self, x: float, y: float) -> bool:
        """Return whether that place is on the button."""
        return self.left <= x <= self.right and self.top <= y <= self.bottom

    def draw(self, canvas: Canvas, marked: bool, dim: bool = False) -> None:
        """Draw the button. marked: the current choice. dim: for the mouse alone."""
        canvas.box(self.left, self.top, self.right, self.bottom, marked=marked)
        middle = ((self.left + self.right) / 2, (self.top + self.bottom) / 2)
        canvas.text(*middle, self.text, _px(self.text, self.right - self.left), DIM if dim else FULL, "mm")


def _px(text: str, width: float) -> int:
    return next((px for px in (28, 24, 20) if width_of(text, px) <= width - 16), 18)


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
    return next((button.name for button in buttons if button.holds(x, y)), "")


def draw_footer(canvas: Canvas, y: float, note: str, hint: str) -> None:
    """Draw the note in full ink, or else the hint, at the foot of a panel."""
    canvas.rows(y, wrapped(note or hint, SMALL, WIDTH - 2 * PAD), SMALL, FULL if note else DIM)


def footer_height(hint: str) -> int:
    """Return the room for the hint and for any note of two lines, so that the panel never jumps."""
    return height_of(max(2, len(wrapped(hint, SMALL, WIDTH - 2 * PAD))), SMALL)
