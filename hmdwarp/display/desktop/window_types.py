"""Types that cross the border to glfw, which is loaded late."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    import ctypes

    import glfw

    WindowHandle = ctypes._Pointer[glfw._GLFWwindow]
    ScreenHandle = ctypes._Pointer[glfw._GLFWmonitor]


class VideoSize(Protocol):
    """Size of a screen in its own units."""

    @property
    def width(self) -> int: ...

    @property
    def height(self) -> int: ...


class VideoMode(Protocol):
    """What a screen is set to."""

    @property
    def size(self) -> VideoSize: ...

    @property
    def refresh_rate(self) -> int: ...  # Hz; 0 where it is unknown
