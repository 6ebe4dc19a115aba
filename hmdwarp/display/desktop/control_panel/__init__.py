"""The control panel over a window: controls and plots, where its package is installed."""

from __future__ import annotations

import os
from itertools import count
from typing import TYPE_CHECKING

import moderngl

from ....resources import install_line
from ...controls import CONTROLS, Control
from ..window_system import WindowHandle

if TYPE_CHECKING:
    from .panel import ControlPanel

PANEL_REMEDY = install_line("panel")


def make_control_panel(
    window: WindowHandle | None,
    gl: moderngl.Context,
    *,
    into: moderngl.Framebuffer | None = None,
    scale: float = 1.0,
    controls: tuple[Control, ...] = CONTROLS,
) -> ControlPanel | None:
    """Return a control panel for a glfw window with the context `gl`.

    None if its package is missing: PANEL_REMEDY names the remedy. Make it after the window has set
    its callbacks: it chains them, and all are still called.
    window: None for a panel without input, at that content scale. into: framebuffer, by default the
    window's. controls: those it shows.

    Its clock is glfw's, or without a window a sixtieth of a second more at each call.
    """
    if not installed():
        return None
    import glfw

    from .imgui_input import ImGuiInput, NoInput
    from .panel import ControlPanel

    panel_input = ImGuiInput(window) if window is not None else NoInput(scale)
    ticking = glfw.get_time if window is not None else count(1, 1 / 60).__next__
    return ControlPanel(gl, panel_input, into or gl.detect_framebuffer(0), ticking, controls)


def installed() -> bool:
    """Return whether the control panel's package is installed and loads (it needs libX11).

    It sets the environment variable that points the glfw package to its own library. That package
    has already loaded its own, and child processes must keep theirs.
    """
    import glfw  # noqa: F401 (first)

    before = os.environ.get("PYGLFW_LIBRARY")
    try:
        from imgui_bundle import imgui, implot  # noqa: F401
    except ImportError:
        return False
    finally:
        if before is None:
            os.environ.pop("PYGLFW_LIBRARY", None)
        else:
            os.environ["PYGLFW_LIBRARY"] = before
    return True


def column_width() -> int:
    """Return the width of the control panel at a content scale of 1; 0 without its package."""
    if not installed():
        return 0
    from .panel_style import WIDTH

    return WIDTH
