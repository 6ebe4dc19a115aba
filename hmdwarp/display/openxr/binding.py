"""Load pyopenxr late: it needs libGL at once and takes a quarter of a second."""

from __future__ import annotations

import os

from ...errors import MachineError
from .diagnosis import diagnose


def load_binding() -> None:
    """Import pyopenxr. Errors: MachineError with the reason.

    Without libGL the import raises AttributeError, with a foreign loader OSError: catch everything.
    """
    os.environ.setdefault("XR_LOADER_DEBUG", "none")  # else the loader prints five lines on what our own error says
    try:
        import xr  # noqa: F401
    except Exception as error:
        words, remedy = diagnose("binding", type(error).__name__, error)
        raise MachineError(f"{words}: {remedy}") from error
