"""Types of glfw, which is loaded late, for annotations."""

from __future__ import annotations

import ctypes

import glfw

WindowHandle = ctypes._Pointer[glfw._GLFWwindow]
ScreenHandle = ctypes._Pointer[glfw._GLFWmonitor]
VideoMode = glfw._GLFWvidmode.GLFWvidmode
