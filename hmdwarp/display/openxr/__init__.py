"""A headset through OpenXR. The binding loads with OpenXrDisplay: it needs libGL and some time."""

from typing import TYPE_CHECKING, Any

from .diagnosis import load_binding

if TYPE_CHECKING:
    from .openxr_display import OpenXrDisplay as OpenXrDisplay


def __getattr__(name: str) -> Any:
    """Load the binding. Errors: MachineError if it does not load."""
    if name != "OpenXrDisplay":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    load_binding()
    from .openxr_display import OpenXrDisplay

    return OpenXrDisplay
