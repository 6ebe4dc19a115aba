"""Loads pyopenxr late: it needs libGL at once and takes a quarter of a second."""

from __future__ import annotations

import os

from ...errors import MachineError
from .diagnosis import diagnose


def load_binding() -> None:
    """Load pyopenxr, or say why not. Errors: MachineError.

    Without libGL the import is an AttributeError, with a foreign loader an OSError: catch
    everything.
    """
    os.environ.setdefault(
        "XR_LOADER_DEBUG", "none"
    )  # else the loader prints what we say in words of our own, in five lines
    try:
        import xr  # noqa: F401
    except Exception as error:
        words, remedy = diagnose("binding", type(error).__name__, error)
        raise MachineError(f"{words}: {remedy}") from error
