"""The control panel over a window: controls and plots, where its packages are installed."""

from __future__ import annotations

import os

from ....base import install_line

PANEL_REMEDY = install_line("panel")
WIDTH = 330  # of the panel in pixels, at a content scale of 1


def installed() -> bool:
    """Return whether the control panel's packages are installed and load (they need libX11).

    They set environment variables that point the glfw package to another library than the one it
    has loaded, and PyOpenGL to X11. Child processes must not inherit them.
    """
    import glfw  # noqa: F401 (first)

    names = ("PYGLFW_LIBRARY", "PYOPENGL_PLATFORM")
    before = {name: os.environ.get(name) for name in names}
    try:
        from imgui_bundle import implot  # noqa: F401
        from imgui_bundle.python_backends import glfw_backend  # noqa: F401
    except ImportError:
        return False
    finally:
        for name, value in before.items():
            os.environ.pop(name, None)
            if value is not None:
                os.environ[name] = value
    return True
