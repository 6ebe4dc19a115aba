"""Optional packages: imported where they are used, and named where they are missing."""

from __future__ import annotations

import importlib
from types import ModuleType

from .errors import MachineError

# What each is for. Which packages they are, pyproject.toml says.
EXTRAS = {
    "bench": "cv2.warpFrame among the warps of bench",
    "cluster": "--cluster",
    "draco": "glTF scenes compressed with Draco",
    "exr": "frames in OpenEXR",
    "feed": "serve and --connect",
    "jod": "--jod",
    "lsl": "--lsl of live and study run",
    "mcap": "head traces in MCAP",
    "panel": "the controls in the window of live; without them there are keys",
    "study": "study analyse and study power, Parquet files, the full-screen console of study run, also in a browser",
}


def install_line(extra: str) -> str:
    """Return the line that installs the packages of an extra."""
    return f"pip install 'hmdwarp[{extra}]'"


def import_extra(module: str, package: str, extra: str) -> ModuleType:
    """Import a module of an optional package.

    Errors: MachineError with the line that installs the package, where it is missing.
    """
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise MachineError(f"this needs {package}, which is not installed: {install_line(extra)}") from error
