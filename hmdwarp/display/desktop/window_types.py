"""Types of glfw, which is imported late, for annotations only."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import ctypes

    import glfw

    WindowHandle = ctypes._Pointer[glfw._GLFWwindow]
    ScreenHandle = ctypes._Pointer[glfw._GLFWmonitor]
    VideoMode = glfw._GLFWvidmode.GLFWvidmode
