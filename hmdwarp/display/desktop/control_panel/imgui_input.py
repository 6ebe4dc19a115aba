"""Mouse and keyboard input for Dear ImGui, through callbacks chained to those of the window."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import glfw
from imgui_bundle import imgui

from ..window_input import label
from ..window_system import WindowHandle

NOWHERE = (-3.4e38, -3.4e38)  # Dear ImGui's value for an absent mouse
BUTTONS = 3  # left, right, middle
# The keys needed to type a number into a slider; all others go to the window alone.
KEYS = {
    glfw.KEY_ENTER: imgui.Key.enter,
    glfw.KEY_KP_ENTER: imgui.Key.keypad_enter,
    glfw.KEY_ESCAPE: imgui.Key.escape,
    glfw.KEY_TAB: imgui.Key.tab,
    glfw.KEY_BACKSPACE: imgui.Key.backspace,
    glfw.KEY_DELETE: imgui.Key.delete,
    glfw.KEY_LEFT: imgui.Key.left_arrow,
    glfw.KEY_RIGHT: imgui.Key.right_arrow,
    glfw.KEY_HOME: imgui.Key.home,
    glfw.KEY_END: imgui.Key.end,
    glfw.KEY_A: imgui.Key.a,
    glfw.KEY_C: imgui.Key.c,
    glfw.KEY_V: imgui.Key.v,
    glfw.KEY_X: imgui.Key.x,
    glfw.KEY_Z: imgui.Key.z,
}
MODIFIERS = {
    glfw.KEY_LEFT_CONTROL: imgui.Key.mod_ctrl,
    glfw.KEY_RIGHT_CONTROL: imgui.Key.mod_ctrl,
    glfw.KEY_LEFT_SHIFT: imgui.Key.mod_shift,
    glfw.KEY_RIGHT_SHIFT: imgui.Key.mod_shift,
}
Event = Callable[[imgui.IO], None]


class ImGuiInput:
    """Input of a glfw window.

    Make it after the window has set its own callbacks, which are still called.
    """

    def __init__(self, window: WindowHandle) -> None:
        self._window = window
        self._events: list[Event] = []
        self._before: list[tuple[Callable[..., Any], Callable[..., Any], Any]] = []
        self._place: tuple[float, float] | None = None
        self.left = 0  # left edge of the panel in framebuffer pixels; set by the panel
        self.typing = False  # whether keys go into the panel; set by it
        self.on = True  # whether to listen
        for setter, callback in (
            (glfw.set_cursor_pos_callback, self._moved),
            (glfw.set_cursor_enter_callback, self._entered),
            (glfw.set_mouse_button_callback, self._clicked),
            (glfw.set_scroll_callback, self._scrolled),
            (glfw.set_key_callback, self._pressed),
            (glfw.set_char_callback, self._typed),
            (glfw.set_window_focus_callback, self._focused),
        ):
            self._chain(setter, callback)

    def _chain(self, setter: Callable[..., Any], callback: Callable[..., None]) -> None:
        def both(*arguments: Any) -> None:
            callback(*arguments[1:])
            if before:
                before(*arguments)

        before = setter(self._window, both)
        self._before.append((setter, both, before))

    @property
    def scale(self) -> float:
        """Content scale of the desktop: 2 on a screen of twice the usual density."""
        return max(glfw.get_window_content_scale(self._window)) or 1.0

    @property
    def captured(self) -> bool:
        """Whether the mouse is captured to turn the head."""
        return glfw.get_input_mode(self._window, glfw.CURSOR) == glfw.CURSOR_DISABLED

    @property
    def cursor(self) -> tuple[float, float] | None:
        """The mouse in framebuffer pixels from the top left.

        None outside, or while the window has captured it.
        """
        return None if self.captured else self._place  # glfw moves a released mouse back to where it was captured

    @staticmethod
    def label(key: str) -> str:
        """Return what the user's keyboard has printed on the key."""
        return label(key)

    def take(self) -> list[Event]:
        """Return the events since the last call, oldest first; call each with ImGui's io object."""
        events, self._events = self._events, []
        return events

    def _in_pixels(self, x: float, y: float) -> tuple[float, float]:
        """Convert the window's own units, which on some desktops are not pixels."""
        (w, h), (fw, fh) = glfw.get_window_size(self._window), glfw.get_framebuffer_size(self._window)
        return x * fw / max(w, 1), y * fh / max(h, 1)

    def _note(self, event: Event) -> None:
        if self.on:
            self._events.append(event)

    # --- callbacks, without the window ---

    def _moved(self, x: float, y: float) -> None:
        place = None if self.captured else self._in_pixels(x, y)
        self._place = place or self._place
        # A position outside the panel counts too: a slider must follow a mouse that slips off.
        self._note(lambda io: io.add_mouse_pos_event(*((place[0] - self.left, place[1]) if place else NOWHERE)))

    def _entered(self, entered: int) -> None:
        if not entered:
            self._place = None
            self._note(lambda io: io.add_mouse_pos_event(*NOWHERE))

    def _clicked(self, button: int, action: int, _: int) -> None:
        if button < BUTTONS and not (action == glfw.PRESS and self.captured):
            self._note(lambda io: io.add_mouse_button_event(button, action == glfw.PRESS))

    def _scrolled(self, x: float, y: float) -> None:
        if not self.captured:
            self._note(lambda io: io.add_mouse_wheel_event(x, y))

    def _pressed(self, key: int, _: int, action: int, __: int) -> None:
        known = MODIFIERS.get(key) or KEYS.get(key)
        if known is not None and action != glfw.REPEAT and (self.typing or key in MODIFIERS or action == glfw.RELEASE):
            self._note(lambda io: io.add_key_event(known, action == glfw.PRESS))

    def _typed(self, codepoint: int) -> None:
        if self.typing:
            self._note(lambda io: io.add_input_character(codepoint))

    def _focused(self, focused: int) -> None:
        self._note(lambda io: io.add_focus_event(bool(focused)))

    def close(self) -> None:
        """Restore the previous callbacks, unless they were replaced since."""
        for setter, ours, before in self._before:
            # None would do by glfw's manual, but its Python package then calls the number 0 at the
            # next event.
            now = setter(self._window, before or _nothing)
            if now is not ours:
                setter(self._window, now)
        self._before.clear()


def _nothing(*_: object) -> None:
    """Do nothing."""


class NoInput:
    """Input of a panel without a user, in a picture for instance."""

    captured = False
    cursor: tuple[float, float] | None = None

    def __init__(self, scale: float = 1.0) -> None:
        self.scale = scale
        self.left, self.typing, self.on = 0, False, True

    @staticmethod
    def label(key: str) -> str:
        """Return the key of a US keyboard."""
        return key

    def take(self) -> list[Event]:
        """Return nothing."""
        return []

    def close(self) -> None:
        """Do nothing."""
