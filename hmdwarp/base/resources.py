"""What this installation has: its version, its non-Python files, the optional packages."""

from __future__ import annotations

import functools
import importlib
import platform
import subprocess
from contextlib import suppress
from importlib import metadata
from pathlib import Path
from types import ModuleType
from typing import Any

from .errors import MachineError

__version__ = "0.2.0"

_PACKAGE = Path(__file__).resolve().parents[1]


@functools.cache
def commit() -> str:
    """Return the commit of this program, with "+" where the checkout has changes; "" if unknown."""
    if (_PACKAGE.parent / ".git").exists():
        with suppress(OSError, subprocess.CalledProcessError):
            git = ["git", "-C", str(_PACKAGE.parent), "describe", "--always", "--abbrev=12", "--exclude=*", "--dirty=+"]
            return subprocess.run(git, capture_output=True, text=True, check=True).stdout.strip()
    return ""


@functools.cache
def made_with() -> dict[str, str]:
    """Return the `made_with` of results: the program's commit, Python, and what draws pictures."""
    packages = {name: metadata.version(name) for name in ("numpy", "moderngl")}
    return {"commit": commit(), "python": platform.python_version(), **packages}


def made_text() -> str:
    """Return what `made_with` says, in a line."""
    return ", ".join(f"{name} {value}" for name, value in made_with().items() if value)


def folder(name: str) -> Path:
    """Return the folder `name` (shaders, recordings) of this installation."""
    for place in (_PACKAGE / "_data" / name, _PACKAGE.parent / name):  # of a wheel, of a checkout
        if place.is_dir():
            return place
    raise FileNotFoundError(f"hmdwarp was installed without its '{name}' folder; reinstall it")


def recording_names() -> list[str]:
    """Return the names of the shipped head traces, without the ending."""
    return sorted(p.stem for p in folder("recordings").glob("*.csv"))


def install_line(extra: str) -> str:
    """Return the line that installs the packages of an extra, in the project's folder."""
    return f"pip install '.[{extra}]'"  # on a package index the name is anybody's yet


def missing_extra(package: str, extra: str) -> str:
    """Return what to say where an optional package is missing: the line that installs it."""
    return f"this needs {package}, which is not installed: {install_line(extra)}"


def import_extra(module: str, package: str, extra: str) -> ModuleType:
    """Import a module of an optional package. Errors: MachineError that says how to install it."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise MachineError(missing_extra(package, extra)) from error


def pyav() -> Any:
    """Return PyAV. Errors: as import_extra."""
    return import_extra("av", "PyAV", "video")
