"""What mouse and keyboard do in a window: they lead the head and ask for commands."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Protocol

import glfw

from ...poses.desktop import Walker
from .. import Command
from .keys import FASTER, MOVES, command_of, direction

TURN_PER_UNIT = math.radians(0.1)  # of the mouse's way: 900 units (of 0.1 mm or so) for a quarter turn


class Greedy(Protocol):
    """A panel that takes some of the input for itself."""

    wants_mouse: bool
    wants_keys: bool


class Hands:
    """Listens to one window and leads `walker`. now_ns: the clock that inputs are timed by, when they are read.

    A click catches the mouse, Escape lets it go; so does another window that comes to the front, which takes the held keys as well.
    panel: takes its part of the input first. commands: what was asked for, oldest first; whoever obeys empties it.
    """

    def __init__(self, window: object, walker: Walker, now_ns: Callable[[], int]) -> None:
        self._window, self._walker, self._now_ns = window, walker, now_ns
        self._held: set[int] = set()
        self._at = (0.0, 0.0)
        self.panel: Greedy | None = None
        self.commands: list[Command] = []
        glfw.set_key_callback(window, self._key)
        glfw.set_mouse_button_callback(window, self._click)
        glfw.set_cursor_pos_callback(window, self._moved)
        glfw.set_window_focus_callback(window, self._focus)

    @property
    def caught(self) -> bool:
        """Whether the mouse turns the head."""
        return glfw.get_input_mode(self._window, glfw.CURSOR) == glfw.CURSOR_DISABLED

    def catch(self) -> None:
        """The mouse is ours: it turns the head and does not leave the window."""
        glfw.set_input_mode(self._window, glfw.CURSOR, glfw.CURSOR_DISABLED)
        if glfw.raw_mouse_motion_supported():  # as the hand moved, without the desktop's acceleration
            glfw.set_input_mode(self._window, glfw.RAW_MOUSE_MOTION, glfw.TRUE)
        self._at = glfw.get_cursor_pos(self._window)

    def let_go(self) -> None:
        """The mouse is the desktop's again."""
        glfw.set_input_mode(self._window, glfw.CURSOR, glfw.CURSOR_NORMAL)

    def lead(self) -> None:
        """Tell the walker which way the held keys lead; after every poll, as it stops by itself when it hears nothing for long."""
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
            if action == glfw.PRESS:
                self._held.add(key)
            return
        command = command_of(key, action, mods)
        if command is not None and command.control == "quit" and self.caught:
            self.let_go()
        elif command is not None:
            self.commands.append(command)

    def _click(self, _: object, __: int, action: int, ___: int) -> None:
        if action == glfw.PRESS and not self.caught and not (self.panel is not None and self.panel.wants_mouse):
            self.catch()

    def _moved(self, _: object, x: float, y: float) -> None:
        if not self.caught:
            return
        across, down = x - self._at[0], y - self._at[1]
        self._at = (x, y)
        self._walker.turn(self._now_ns(), -across * TURN_PER_UNIT, -down * TURN_PER_UNIT)

    def _focus(self, _: object, focused: int) -> None:
        if not focused:
            self._held.clear()
            if self.caught:
                self.let_go()


class LedHead:
    """The walker as a source of poses that reads its inputs right before it answers."""

    def __init__(self, walker: Walker, read_inputs: Callable[[], int]) -> None:
        self._walker, self._read_inputs = walker, read_inputs

    def start(self) -> None:
        """As PoseSource.start: the window listens already."""

    def head_at(self, time_ns: int):
        """As PoseSource.head_at, with inputs as new as can be. read_inputs reads them and says when that was."""
        self._walker.advance(self._read_inputs())
        return self._walker.head_at(time_ns)

    def close(self) -> None:
        """As PoseSource.close: the window is not ours."""
