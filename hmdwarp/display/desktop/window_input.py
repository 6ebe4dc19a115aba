"""Mouse and keyboard of a window: they move the head and make commands."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import glfw

from ...poses import PoseSample, Walker
from .. import Command
from ..controls import MOVING, Control, Status, and_mouse
from .control_panel import installed
from .window import Window

if TYPE_CHECKING:
    from .control_panel.panel import ControlPanel

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
_STEPS_BACK = ("choice", "number")
HELD = ("number", "step")  # repeat while their key is held
FASTER = (glfw.KEY_LEFT_SHIFT, glfw.KEY_RIGHT_SHIFT)
BUTTONS = {"left": glfw.MOUSE_BUTTON_LEFT, "middle": glfw.MOUSE_BUTTON_MIDDLE, "right": glfw.MOUSE_BUTTON_RIGHT}
_OTHERS = glfw.MOD_CONTROL | glfw.MOD_ALT | glfw.MOD_SUPER


def token(name: str) -> int:
    """Return glfw's number for a key's name in the controls."""
    return _NAMED[name] if name in _NAMED else getattr(glfw, f"KEY_{name.upper().replace(' ', '_')}")


class Keys:
    """The keys of some controls: of those that are offered at the moment."""

    def __init__(self, controls: tuple[Control, ...]) -> None:
        self.controls, self.status = controls, Status()
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
        if not self.status.offers(control) or (action == glfw.REPEAT and control.kind not in HELD):
            return None
        shifted = bool(mods & glfw.MOD_SHIFT) and not control.back and control.kind in _STEPS_BACK
        return Command(control.name, control.value, back=back or shifted)

    def command_of_button(self, button: int, action: int) -> Command | None:
        """Return the command of a captured mouse, None for none. Arguments: as in glfw."""
        for control in filter(self.status.offers, self.controls):
            if control.mouse and BUTTONS[control.mouse] == button:
                if control.kind == "hold":
                    return Command(control.name, action == glfw.PRESS)
                return Command(control.name, control.value) if action == glfw.PRESS else None
        return None

    def first_words(self, looks: bool) -> list[str]:
        """Return a line for the first picture, none where nothing may be written over pictures.

        looks: whether the mouse turns the head.
        """
        keys = [one.key for one in self.controls if one.name == "help" and not one.needs_text_panel]
        return [f"{'click to look, ' if looks else ''}{label(key)} for help" for key in keys[:1]]

    def help_text(self, *, moves: bool = True) -> str:
        """Return every control, after every way to move, a line each: keys, tab, description."""
        rows = []
        for keys, what in MOVING if moves else ():
            rows.append((" ".join(label(word) if len(word) == 1 else word for word in keys.split()), what))
        for control in (one for one in self.controls if one.what and self.status.offers(one)):
            keys = control.written or " ".join(label(key) for key in (control.back, control.key) if key)
            if not control.written and not control.back:
                keys += " (shift: back)" if control.kind in _STEPS_BACK else and_mouse(control) if moves else ""
            rows.append((keys, control.what))
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


_TURN_PER_UNIT = math.radians(0.1)  # of mouse motion: 900 units (of 0.1 mm or so) for a quarter turn

# A position in the window's own units, from the top left, to (u, v) of the text panel; None
# outside.
Locate = Callable[[float, float], tuple[float, float] | None]


class WindowInput:
    """Mouse, keyboard and control panel of a window: they move `walker` and make commands.

    now_ns: the clock for the times of inputs, taken when they are read. own: does what a control of
    the window itself requests, by its name and value. A click captures the mouse, and so does
    `look`; in a window without the focus that takes effect once it has it. The key of "quit"
    releases it, and so does a change to another window, which releases the held keys as well.
    """

    def __init__(
        self, shown: Window, walker: Walker, now_ns: Callable[[], int], keys: Keys, own: Callable[[str, object], None]
    ) -> None:
        self._shown, self._walker, self._now_ns, self._keys = shown, walker, now_ns, keys
        self._window, self._own = shown.handle, own
        self._held: set[int] = set()
        self._position = (0.0, 0.0)
        self._locate: Locate | None = None
        self._capture_again = False
        self._notches = 0.0  # fraction of a wheel notch not reported yet
        self.panel: ControlPanel | None = None  # takes its part of the input first; None until it is opened
        self.help = False  # whether the help covers the picture, in place of any other text
        self.takes_text = False  # whether letters are text, and no keys of controls
        self.commands: list[Command] = []  # requests, oldest first
        glfw.set_key_callback(self._window, self._key)
        glfw.set_char_callback(self._window, self._typed)
        glfw.set_mouse_button_callback(self._window, self._click)
        glfw.set_cursor_pos_callback(self._window, self._moved)
        glfw.set_scroll_callback(self._window, self._scrolled)
        glfw.set_window_focus_callback(self._window, self._focus)

    def read(self) -> int:
        """Read mouse and keys, move the walker, and return the time."""
        self._shown.poll_events()
        # After every poll: the walker stops without input.
        right, up, forward = direction(self._held)
        self._walker.walk(self._now_ns(), right, up, forward, fast=not self._held.isdisjoint(FASTER))
        return self._now_ns()

    def take(self) -> list[Command]:
        """Return the commands for the run since the last call; do the window's own."""
        commands, self.commands = self.commands, []
        own = {one.name for one in self._keys.controls if one.of_display}
        for command in commands:
            if command.control in own:
                self._own(command.control, command.value)
        return [command for command in commands if command.control not in own]

    def open_panel(self) -> bool:
        """Open the control panel; return whether its packages are installed."""
        if installed():
            from .control_panel.panel import ControlPanel

            # After the window has set its callbacks: the panel chains them.
            self.panel = ControlPanel(self._window, self._shown.gl, self._keys.controls, label)
        return self.panel is not None

    def close(self) -> None:
        if self.panel is not None:
            self.panel.close()

    def point(self, locate: Locate | None) -> None:
        """Let the mouse point at a text panel from now on; None returns it to the head."""
        if (locate is None) == (self._locate is None):
            return
        self._locate = locate
        self._held.clear()
        if locate is None and self._capture_again:
            self.capture()
        elif locate is not None:
            self._capture_again, self._notches = self.captured, 0.0
            if self.captured:
                self.release()

    def look(self) -> None:
        """Turn the head with the mouse from now on, or once it points at no text panel."""
        if self._locate is not None:
            self._capture_again = True
        elif not self.captured:
            self.capture()

    @property
    def captured(self) -> bool:
        """Whether the mouse turns the head."""
        return glfw.get_input_mode(self._window, glfw.CURSOR) == glfw.CURSOR_DISABLED

    def capture(self) -> None:
        """Let the mouse turn the head and not leave the window."""
        glfw.set_input_mode(self._window, glfw.CURSOR, glfw.CURSOR_DISABLED)
        if glfw.raw_mouse_motion_supported():  # without the desktop's pointer acceleration
            glfw.set_input_mode(self._window, glfw.RAW_MOUSE_MOTION, glfw.TRUE)
        self._position = glfw.get_cursor_pos(self._window)

    def release(self) -> None:
        glfw.set_input_mode(self._window, glfw.CURSOR, glfw.CURSOR_NORMAL)

    # --- glfw's callbacks ---

    def _key(self, _: object, key: int, __: int, action: int, mods: int) -> None:
        if action == glfw.RELEASE:
            self._held.discard(key)
            return
        if self.panel is not None and self.panel.wants_keys:
            return
        if key in MOVES or key in FASTER:
            if action == glfw.PRESS and self._locate is None:
                self._held.add(key)
            return
        if self.takes_text and prints(key):
            return
        command = self._keys.command_of(key, action, mods)
        if key == glfw.KEY_ESCAPE and self.help:
            self.help = False
        elif command is not None and command.control == "quit" and self.captured:
            self.release()
        elif command is not None:
            self.commands.append(command)

    def _typed(self, _: object, code: int) -> None:
        if self.takes_text:
            self.commands.append(Command("type", chr(code)))

    def _click(self, _: object, button: int, action: int, ___: int) -> None:
        if self.captured or action != glfw.PRESS:
            command = self._keys.command_of_button(button, action)
            # What was held is let go wherever the mouse is by then.
            if command is not None and (self.captured or command.value is False):
                self.commands.append(command)
            return
        if self._is_for_control_panel:
            return
        if self._locate is None:
            self.capture()
        elif button == glfw.MOUSE_BUTTON_LEFT:
            self._add("press", self._locate(*glfw.get_cursor_pos(self._window)))

    @property
    def _is_for_control_panel(self) -> bool:
        return self.panel is not None and self.panel.wants_mouse

    def _add(self, name: str, uv: tuple[float, float] | None) -> None:
        """Add a pointer command; drop those off the text panel, keep only the last of a motion."""
        if uv is None:
            return
        if name == "point" and self.commands and self.commands[-1].control == name:
            self.commands.pop()
        self.commands.append(Command(name, uv))

    def _scrolled(self, _: object, __: float, up: float) -> None:
        if self._locate is None or self._is_for_control_panel:
            return
        notches = int(self._notches + up)  # touchpads scroll in fractions
        self._notches += up - notches
        self.commands += [Command("up" if notches > 0 else "down")] * abs(notches)

    def _moved(self, _: object, x: float, y: float) -> None:
        if not self.captured:
            if self._locate is not None and not self._is_for_control_panel:
                self._add("point", self._locate(x, y))
            return
        across, down = x - self._position[0], y - self._position[1]
        self._position = (x, y)
        self._walker.turn(self._now_ns(), -across * _TURN_PER_UNIT, -down * _TURN_PER_UNIT)

    def _focus(self, _: object, focused: int) -> None:
        if not focused:
            self._held.clear()
            self._capture_again = False
            if self.captured:
                self.release()


class WalkerSource:
    """Poses of the walker. read_inputs: reads its inputs, before each answer; returns the time."""

    def __init__(self, walker: Walker, read_inputs: Callable[[], int]) -> None:
        self._walker, self._read_inputs = walker, read_inputs

    def start(self) -> None:
        """Do nothing: the window already listens."""

    def head_at(self, time_ns: int) -> PoseSample:
        self._walker.advance(self._read_inputs())
        return self._walker.head_at(time_ns)

    def close(self) -> None:
        """Do nothing: the window belongs to the display."""
