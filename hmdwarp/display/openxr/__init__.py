"""A headset through OpenXR. The binding loads with the first name: it needs libGL and some time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .diagnosis import INSTALL, RUNTIME_LABEL, diagnose, manifest_text, missing_extensions

if TYPE_CHECKING:
    from .openxr_display import OpenXrDisplay

__all__ = ["INSTALL", "RUNTIME_LABEL", "OpenXrDisplay", "diagnose", "manifest_text", "missing_extensions"]


def __getattr__(name: str) -> Any:
    """Load the binding. Errors: MachineError if it does not load."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from .diagnosis import load_binding

    load_binding()
    from . import openxr_display

    return getattr(openxr_display, name)
