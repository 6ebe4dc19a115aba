"""Follow screens as they are plugged in and out, and their refresh rates."""

from __future__ import annotations

from types import ModuleType

from .pacing import Pacer, known_rate
from .window import Window

CHECK_NS = 1_000_000_000  # between two checks of which screen the window is on


class ScreenMonitor:
    """Keep the pacer at the refresh rate of the window's screen."""

    def __init__(self, glfw: ModuleType, window: Window, pacer: Pacer) -> None:
        self._window, self._pacer = window, pacer
        self._changed, self._checked_ns = False, 0
        glfw.set_monitor_callback(self._note_change)

    def _note_change(self, *_: object) -> None:
        self._changed = True

    def update(self, now_ns: int) -> None:
        """Check the screen, if one was plugged or unplugged or the last check is a second old."""
        if not self._changed and now_ns - self._checked_ns < CHECK_NS:
            return
        self._checked_ns = now_ns
        if self._changed:
            self._changed = False
            self._window.screens_changed()
        rate_hz = self._window.rate_hz
        if known_rate(rate_hz) != self._pacer.rate_hz:
            self._pacer.set(rate_hz, self._window.vsync)
