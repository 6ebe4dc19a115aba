"""Options of what a command writes, and the one rule they all keep.

A file that exists is not overwritten, and a folder of results is renewed by the command that made
it; `--force` overrides both. report.output checks it.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import attrs

from ..errors import InputError
from .declared import CONDITION, Option, option

FORCE = Option("Overwrite files that are in the way, also those that another program wrote.", bool, False, name="force")


def path_of(value: str | os.PathLike[str], flag: str = "--out") -> Path:
    """Return a path. Errors: InputError for an empty text, which would be the working folder."""
    if isinstance(value, str) and not value.strip():
        raise InputError(f"{flag} '{value}': expected a name; '.' is the working folder")
    return Path(value)


def out_field(value: Any, help: str, /, **about: Any) -> Any:
    """Return the field of a file or folder to write; value: its default, as `option` takes it."""
    optional = value is None
    return option(value, help, kind=Path, convert=attrs.converters.optional(path_of) if optional else path_of, **about)


def force_field(study: str = CONDITION) -> Any:
    """Return the field of `--force`. study: why a study's file may not set it."""
    return option(False, FORCE.help, study=study)
