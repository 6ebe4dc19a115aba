"""Locate non-Python files: beside the package in a checkout, inside it in an installed wheel."""

from __future__ import annotations

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent


def folder(name: str) -> Path:
    """Return the folder `name` (shaders, recordings) of this installation.

    Errors: FileNotFoundError if it was not shipped.
    """
    for place in (_PACKAGE / "_data" / name, _PACKAGE.parent / name):
        if place.is_dir():
            return place
    raise FileNotFoundError(f"hmdwarp was installed without its '{name}' folder; reinstall it")


def recording_names() -> list[str]:
    """Return the names of the shipped head traces, without the ending."""
    return sorted(p.stem for p in folder("recordings").glob("*.csv"))
