"""A headset through OpenXR. The binding loads with the first name: it needs libGL and a moment."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .display import OpenXrDisplay
    from .head import OpenXrHead

__all__ = ["OpenXrDisplay", "OpenXrHead"]
WHO = "the OpenXR runtime"  # corrects the lens and takes depth, as a plan tells it


def __getattr__(name: str) -> Any:
    """Load the binding. Errors: MachineError where it does not load."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from .binding import load_binding

    load_binding()
    if name == "OpenXrHead":
        from .head import OpenXrHead

        return OpenXrHead
    from .display import OpenXrDisplay

    return OpenXrDisplay
