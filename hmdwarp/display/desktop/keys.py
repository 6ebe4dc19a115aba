"""Map keys of a glfw window to commands, also for the window beside a headset."""

from __future__ import annotations

from collections.abc import Callable

import glfw

from .. import Command
from ..controls import MOVING, Control

# A control's key is where a US keyboard has it, so that one finger finds the same control
# everywhere; the help writes what the user's own keyboard has printed there.
_NAMED = {"[": glfw.KEY_LEFT_BRACKET, "]": glfw.KEY_RIGHT_BRACKET, ".": glfw.KEY_PERIOD, ",": glfw.KEY_COMMA}
# Right, up, forward.
MOVES = {
    glfw.KEY_W: (0, 0, 1),
    glfw.KEY_S: (0, 0, -1),
    glfw.KEY_A: (-1, 0, 0),
    glfw.KEY_D: (1, 0, 0),
    glfw.KEY_E: (0, 1, 0),
    glfw.KEY_Q: (0, -1, 0),
}
STEPS_BACK = ("choice", "number")
HELD = ("number", "step")  # repeat while their key is held
FASTER = (glfw.KEY_LEFT_SHIFT, glfw.KEY_RIGHT_SHIFT)
_OTHERS = glfw.MOD_CONTROL | glfw.MOD_ALT | glfw.MOD_SUPER


def token(name: str) -> int:
    """Return glfw's number for a key's name in the controls."""
    return _NAMED[name] if name in _NAMED else getattr(glfw, f"KEY_{name.upper().replace(' ', '_')}")


class Keys:
    """The keys of some controls."""

    def __init__(self, controls: tuple[Control, ...]) -> None:
        self.controls = controls
        self._of_key: dict[int, tuple[Control, bool]] = {}
        for control in controls:
            self._of_key.update((token(key), (control, False)) for key in (control.key, *control.also))
            if control.back:
                self._of_key[token(control.back)] = (control, True)

    def command_of(self, key: int, action: int, mods: int) -> Command | None:
        """Return the command for a key event, None for none.

        Arguments as in glfw's callback. Numbers and steps repeat while their key is held;
        everything else acts once a press. Shift steps back, unless the control has a key for that.
        With Ctrl, Alt or Super a key belongs to the desktop.
        """
        if key not in self._of_key or mods & _OTHERS or action == glfw.RELEASE:
            return None
        control, back = self._of_key[key]
        if action == glfw.REPEAT and control.kind not in HELD:
            return None
        shifted = bool(mods & glfw.MOD_SHIFT) and not control.back and control.kind in STEPS_BACK
        return Command(control.name, control.value, back=back or shifted)

    def first_words(self, looks: bool, named: Callable[[str], str] | None = None) -> list[str]:
        """Return a line for the first picture, none where nothing may be written over pictures.

        looks: whether the mouse turns the head.
        """
        help_ = next((one for one in self.controls if one.name == "help" and not one.needs_text_panel), None)
        if help_ is None:
            return []
        return [f"{'click to look, ' if looks else ''}{(named or label)(help_.key)} for help"]

    def help_text(self, named: Callable[[str], str] | None = None) -> str:
        """Return every way to move and every control, a line each: keys, tab, description.

        named: maps a key to the user's name for it.
        """
        named = named or label
        rows = [
            (" ".join(named(word) if len(word) == 1 else word for word in keys.split()), what) for keys, what in MOVING
        ]
        rows += [(_keys_of(control, named), control.what) for control in self.controls if control.what]
        return "\n".join(f"{keys}\t{what}" for keys, what in rows)


def direction(held: set[int]) -> tuple[int, int, int]:
    """Return right, up, forward, -1..1 each, of the held keys; opposite ones cancel."""
    moves = [MOVES[key] for key in held if key in MOVES]
    right, up, forward = (sum(axis) for axis in zip(*moves, strict=True)) if moves else (0, 0, 0)
    return right, up, forward


def prints(key: int) -> bool:
    """Return whether a key writes a character, by glfw's numbers."""
    return key < glfw.KEY_ESCAPE or (glfw.KEY_KP_0 <= key <= glfw.KEY_KP_EQUAL and key != glfw.KEY_KP_ENTER)


def label(name: str) -> str:
    """Return the user's keyboard label of that key. glfw must be running."""
    printed = glfw.get_key_name(token(name), 0) if len(name) == 1 else None
    return printed.upper() if printed else name


def _keys_of(control: Control, named: Callable[[str], str]) -> str:
    if control.written:
        return control.written
    if control.back:
        return f"{named(control.back)} {named(control.key)}"
    return f"{named(control.key)} (shift: back)" if control.kind in STEPS_BACK else named(control.key)
