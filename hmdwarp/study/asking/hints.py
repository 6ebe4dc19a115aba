"""What hands can do, in a few words: keys and a mouse before a window, controllers in a headset."""

from __future__ import annotations

import attrs

from .paper import DIM, FULL, LARGE, PAD, SMALL, WIDTH, Paper, height_of, width_of, wrapped

BUTTON_HIGH = round(1.5 * LARGE)
GAP = 12


@attrs.frozen
class Hints:
    """choose: by what a value of a scale is chosen. pick: by what one of several buttons. step: of these, what has no digits and no mouse.
    confirm: what does that. menu: what opens it. skip: what leaves a question unanswered, "" where the menu does. mouse: whether there is
    one, so that buttons are worth drawing."""

    choose: str
    pick: str
    step: str
    confirm: str
    menu: str
    skip: str = ""
    mouse: bool = False


KEYS = Hints("arrows, digits or mouse", "arrows or mouse", "arrows", "Enter", "Esc", "X", mouse=True)
CONTROLLERS = Hints("stick or pad", "stick or pad", "stick or pad", "trigger", "menu button")


def picking_hint(hints: Hints) -> str:
    """Under buttons."""
    return f"{hints.pick}: choose\n{hints.confirm}: confirm"


def hints_for(display: str) -> Hints:
    """For a display by its name."""
    return CONTROLLERS if display == "openxr" else KEYS


@attrs.frozen
class Button:
    """name: what is chosen by it. text: on it. Pixels of the plate, y down."""

    name: str
    text: str
    left: float
    top: float
    right: float

    @property
    def bottom(self) -> float:
        """As high as every button."""
        return self.top + BUTTON_HIGH

    def holds(self, x: float, y: float) -> bool:
        """Whether that place is on it."""
        return self.left <= x <= self.right and self.top <= y <= self.bottom

    def draw(self, paper: Paper, marked: bool, dim: bool = False) -> None:
        """marked: whether it is the one that is meant. dim: whether it is there for the mouse alone."""
        paper.box(self.left, self.top, self.right, self.bottom, marked=marked)
        middle = ((self.left + self.right) / 2, (self.top + self.bottom) / 2)
        paper.text(*middle, self.text, _px(self.text, self.right - self.left), DIM if dim else FULL, "mm")


def _px(text: str, width: float) -> int:
    return next((px for px in (28, 24, 20) if width_of(text, px) <= width - 16), 18)


def row_of(choices: tuple[tuple[str, str], ...], top: float) -> tuple[Button, ...]:
    """Buttons (name, text) side by side, over the whole width."""
    each = (WIDTH - 2 * PAD - GAP * (len(choices) - 1)) / max(len(choices), 1)
    return tuple(
        Button(name, text, PAD + k * (each + GAP), top, PAD + k * (each + GAP) + each)
        for k, (name, text) in enumerate(choices)
    )


def column_of(choices: tuple[tuple[str, str], ...], top: float) -> tuple[Button, ...]:
    """Buttons (name, text) one under the other."""
    down = BUTTON_HIGH + GAP
    return tuple(Button(name, text, PAD, top + k * down, WIDTH - PAD) for k, (name, text) in enumerate(choices))


def told(paper: Paper, y: float, note: str, hint: str) -> float:
    """At the foot of a plate: the note, in full ink, in place of the hint."""
    paper.rows(y, wrapped(note or hint, SMALL, WIDTH - 2 * PAD), SMALL, FULL if note else DIM)
    return y + told_height(hint)


def told_height(hint: str) -> int:
    """Room for the hint and for any note of two lines, so that the plate stays as it is."""
    return height_of(max(2, len(wrapped(hint, SMALL, WIDTH - 2 * PAD))), SMALL)
