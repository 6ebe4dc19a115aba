"""Mouse and keyboard of a window: they lead the head and request commands."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Protocol

import glfw

from ...poses.desktop import Walker
from .. import Command
from .keys import FASTER, MOVES, Keys, direction

TURN_PER_UNIT = math.radians(0.1)  # of the mouse's way: 900 units (of 0.1 mm or so) for a quarter turn


Pointing = Callable[[float, float], tuple[float, float] | None]


class Greedy(Protocol):
    """A panel that takes some of the input for itself."""

    wants_mouse: bool
    wants_keys: bool


class Hands:
    """Listens to one window and leads `walker`.

    now_ns: the clock that inputs are timed by, when they are read. A click catches the mouse, the
    key of "quit" releases it; so does another window that comes to the front, which takes the held
    keys as well.
    panel: takes its part of the input first. commands: requests, oldest first; the caller empties
    it.
    """

    def __init__(self, window: object, walker: Walker, now_ns: Callable[[], int], keys: Keys) -> None:
        self._window, self._walker, self._now_ns, self._keys = window, walker, now_ns, keys
        self._held: set[int] = set()
        self._at = (0.0, 0.0)
        self._pointing: Pointing | None = None
        self._catch_again = False
        self._turned = 0.0  # of the wheel, as far as it is no whole notch yet
        self.panel: Greedy | None = None
        self.commands: list[Command] = []
        glfw.set_key_callback(window, self._key)
        glfw.set_mouse_button_callback(window, self._click)
        glfw.set_cursor_pos_callback(window, self._moved)
        glfw.set_scroll_callback(window, self._scrolled)
        glfw.set_window_focus_callback(window, self._focus)

    def point(self, pointing: Pointing | None) -> None:
        """Point with the mouse at a panel from now on, without walking; None gives the head back.

        pointing: where on the panel a place of the window is, in its own units from the top left.
        """
        if (pointing is None) == (self._pointing is None):
            return
        self._pointing = pointing
        self._held.clear()
        if pointing is None and self._catch_again:
            self.catch()
        elif pointing is not None:
            self._catch_again, self._turned = self.caught, 0.0
            if self.caught:
                self.let_go()

    @property
    def caught(self) -> bool:
        """Whether the mouse turns the head."""
        return glfw.get_input_mode(self._window, glfw.CURSOR) == glfw.CURSOR_DISABLED

    def catch(self) -> None:
        """Catch the mouse: it turns the head and does not leave the window."""
        glfw.set_input_mode(self._window, glfw.CURSOR, glfw.CURSOR_DISABLED)
        if glfw.raw_mouse_motion_supported():  # as the hand moved, without the desktop's acceleration
            glfw.set_input_mode(self._window, glfw.RAW_MOUSE_MOTION, glfw.TRUE)
        self._at = glfw.get_cursor_pos(self._window)

    def let_go(self) -> None:
        """Release the mouse to the desktop."""
        glfw.set_input_mode(self._window, glfw.CURSOR, glfw.CURSOR_NORMAL)

    def lead(self) -> None:
        """Tell the walker which way the held keys lead.

        Call after every poll: the walker stops by itself without input.
        """
        right, up, forward = direction(self._held)
        self._walker.walk(self._now_ns(), right, up, forward, fast=not self._held.isdisjoint(FASTER))

    # --- glfw's callbacks ---

    def _key(self, _: object, key: int, __: int, action: int, mods: int) -> None:
        if action == glfw.RELEASE:
            self._held.discard(key)
            return
        if self.panel is not None and self.panel.wants_keys:
            return
        if key in MOVES or key in FASTER:
            if action == glfw.PRESS and self._pointing is None:
                self._held.add(key)
            return
        command = self._keys.command_of(key, action, mods)
        if command is not None and command.control == "quit" and self.caught:
            self.let_go()
        elif command is not None:
            self.commands.append(command)

    def _click(self, _: object, button: int, action: int, ___: int) -> None:
        if action != glfw.PRESS or self.caught or self._of_panel:
            return
        if self._pointing is None:
            self.catch()
        elif button == glfw.MOUSE_BUTTON_LEFT:
            self._note("press", self._pointing(*glfw.get_cursor_pos(self._window)))

    @property
    def _of_panel(self) -> bool:
        return self.panel is not None and self.panel.wants_mouse

    def _note(self, what: str, place: tuple[float, float] | None) -> None:
        """Note a pointer command; drop those off the panel, and keep only the last of a motion."""
        if place is None:
            return
        if what == "point" and self.commands and self.commands[-1].control == what:
            self.commands.pop()
        self.commands.append(Command(what, place))

    def _scrolled(self, _: object, __: float, up: float) -> None:
        if self._pointing is None or self._of_panel:
            return
        self._turned += up
        notches = int(self._turned)  # touchpads turn it in small parts
        self._turned -= notches
        self.commands += [Command("up" if notches > 0 else "down")] * abs(notches)

    def _moved(self, _: object, x: float, y: float) -> None:
        if not self.caught:
            if self._pointing is not None and not self._of_panel:
                self._note("point", self._pointing(x, y))
            return
        across, down = x - self._at[0], y - self._at[1]
        self._at = (x, y)
        self._walker.turn(self._now_ns(), -across * TURN_PER_UNIT, -down * TURN_PER_UNIT)

    def _focus(self, _: object, focused: int) -> None:
        if not focused:
            self._held.clear()
            self._catch_again = False
            if self.caught:
                self.let_go()


class LedHead:
    """The walker as a source of poses that reads its inputs right before it answers."""

    def __init__(self, walker: Walker, read_inputs: Callable[[], int]) -> None:
        self._walker, self._read_inputs = walker, read_inputs

    def start(self) -> None:
        """Do nothing: the window listens already."""

    def head_at(self, time_ns: int):
        """Return the head with inputs as new as can be; read_inputs reads them and returns when."""
        self._walker.advance(self._read_inputs())
        return self._walker.head_at(time_ns)

    def close(self) -> None:
        """Do nothing: the window is not ours."""
