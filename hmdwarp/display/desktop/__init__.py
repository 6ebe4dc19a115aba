"""A window on the desktop in place of the headset, and a head moved by mouse and keys."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .desktop_display import DesktopDisplay

__all__ = ["DesktopDisplay"]


def __getattr__(name: str) -> Any:
    # Late, so that the parts that know no window (layout, pacing) load without glfw.
    if name == "DesktopDisplay":
        from .desktop_display import DesktopDisplay

        return DesktopDisplay
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
