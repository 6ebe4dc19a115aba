"""Packages that only the study commands need."""

from __future__ import annotations

import importlib
from types import ModuleType

from ..errors import MachineError

INSTALL = "pip install 'hmdwarp[study]'"


def import_extra(module: str, package: str) -> ModuleType:
    """Import a module of an optional package.

    Errors: MachineError with the line that installs the package, where it is missing.
    """
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise MachineError(f"this needs {package}, which is not installed: {INSTALL}") from error
