"""Controls of a participant, on every display."""

from __future__ import annotations

import attrs

from ...display import Control, control

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
