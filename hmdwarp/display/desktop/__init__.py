"""A window on the desktop in the headset's place, and a head led by mouse and keys."""

from __future__ import annotations

from typing import Any

__all__ = ["DesktopDisplay"]


def __getattr__(name: str) -> Any:
    # Late, so that the parts that know no window (layout, pacing) load without glfw.
    if name == "DesktopDisplay":
        from .desktop import DesktopDisplay

        return DesktopDisplay
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
