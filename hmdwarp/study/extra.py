"""The packages that only a study needs."""

from __future__ import annotations

import importlib
from types import ModuleType

from ..errors import MachineError


def needed(module: str, package: str) -> ModuleType:
    """The module of that name, imported. Errors: MachineError saying how to get the package where it is not installed."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise MachineError(f"this needs {package}, which is not installed: pip install 'hmdwarp[study]'") from error
