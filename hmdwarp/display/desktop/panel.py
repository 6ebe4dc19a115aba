"""The control panel over a window: controls and plots, where its package is installed."""

from __future__ import annotations

import os
from collections.abc import Callable
from itertools import count
from typing import TYPE_CHECKING, Any

import moderngl

from ..controls import CONTROLS, Control

if TYPE_CHECKING:
    from .panel_shown import Panel

HOW_TO_GET_THE_PANEL = "pip install 'hmdwarp[panel]'"


def make_panel(
    window: Any,
    gl: moderngl.Context,
    *,
    into: moderngl.Framebuffer | None = None,
    clock: Callable[[], float] | None = None,
    scale: float = 1.0,
    controls: tuple[Control, ...] = CONTROLS,
) -> Panel | None:
    """Return a panel for a glfw window whose context is `gl`; None where its package is missing.

    Then HOW_TO_GET_THE_PANEL is the remedy. Make it after the window has set its callbacks: they
    are chained, and all of them are still called.
    window: None for a panel without input, at that content scale. into: framebuffer, by default the
    window's. clock: running seconds; glfw's by default, and without a window a sixtieth more at
    each call. controls: those it shows.
    """
    if not installed():
        return None
    import glfw

    from .panel_input import NoInput, PanelInput
    from .panel_shown import Panel

    heard = PanelInput(window) if window is not None else NoInput(scale)
    ticking = glfw.get_time if window is not None else count(1, 1 / 60).__next__
    return Panel(gl, heard, into or gl.detect_framebuffer(0), clock or ticking, controls)


def installed() -> bool:
    """Tell whether the panel's package is there and loads (it needs libX11).

    It brings a glfw library of its own and names it in the environment for the glfw package. That
    one has its own already, and programs started from here keep theirs.
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
