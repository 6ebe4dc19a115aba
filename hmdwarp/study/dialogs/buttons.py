"""Participant's controls, and the buttons and hints of a panel."""

from __future__ import annotations

import attrs

from ...display import Control, control
from .canvas import DIM, FULL, LARGE, PAD, SMALL, WIDTH, Canvas, height_of, width_of, wrapped

_KEYPAD = {str(digit): (f"KP {digit}",) for digit in range(10)}
_DIGITS = tuple(Control("digit", key, "", "action", also=also, value=key) for key, also in _KEYPAD.items())
_POINT = Control("digit", ".", "a number", "action", also=(",", "KP Decimal"), value=".", written="0 to 9 .")

# W A S D Q E walk. Escape opens the menu, which offers the end: a slip must not end a session, and
# the way out must be easy to find.
CONTROLS: tuple[Control, ...] = (
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
    control("recentre"),
    control("full_screen"),
    attrs.evolve(control("help"), needs_text_panel=True),  # never over a trial's picture
)


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


KEYS = InputHints(
    choose="arrows, digits or mouse",
    pick="arrows or mouse",
    step="arrows",
    confirm="Enter",
    menu="Esc",
    look="Move the mouse to look around all the time; W A S D walk.",
    skip="X",
    mouse=True,
)
CONTROLLERS = InputHints(
    choose="stick or pad",
    pick="stick or pad",
    step="stick or pad",
    confirm="trigger",
    menu="menu button",
    look="Turn your head to look around all the time.",
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
