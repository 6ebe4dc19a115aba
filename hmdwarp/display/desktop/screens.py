"""The window's screen, and that screen's mode."""

from __future__ import annotations

from types import ModuleType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .window_types import ScreenHandle, VideoMode, WindowHandle

UNKNOWN = "none"


def screen_of(glfw: ModuleType, handle: WindowHandle) -> ScreenHandle | None:
    """Return the screen that a window fills, or that most of it lies on; None without any."""
    filled = glfw.get_window_monitor(handle)
    if filled:
        return filled
    x, y = glfw.get_window_pos(handle)  # (0, 0) under Wayland, which does not report it
    w, h = glfw.get_window_size(handle)
    return max(glfw.get_monitors() or [], key=lambda screen: _shared(glfw, screen, (x, y, w, h)), default=None)


def _shared(glfw: ModuleType, screen: ScreenHandle, rectangle: tuple[int, int, int, int]) -> int:
    """Return the area of the rectangle on the screen."""
    mode = glfw.get_video_mode(screen)
    if mode is None:
        return 0
    x, y, w, h = rectangle
    left, top = glfw.get_monitor_pos(screen)
    across = min(x + w, left + mode.size.width) - max(x, left)
    down = min(y + h, top + mode.size.height) - max(y, top)
    return max(0, across) * max(0, down)


def mode_of(glfw: ModuleType, screen: ScreenHandle | None) -> VideoMode | None:
    """Return size and refresh_rate of a screen; None without one."""
    return glfw.get_video_mode(screen) if screen else None


def screen_text(glfw: ModuleType, screen: ScreenHandle | None) -> str:
    """Return the screen's name, size and rate."""
    mode = mode_of(glfw, screen)
    if mode is None:
        return UNKNOWN
    name = glfw.get_monitor_name(screen)
    name = name.decode(errors="replace") if isinstance(name, bytes) else str(name)
    rate = f" at {mode.refresh_rate} Hz" if mode.refresh_rate > 0 else ""
    return f"{name}, {mode.size.width}x{mode.size.height}{rate}"
