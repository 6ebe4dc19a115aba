"""Read and parse whole files; errors name the line: `study.toml:14: trial.order is ..`."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import attrs

from ...errors import InputError
from ..documents import DocumentError, parse_toml
from ..named_files import TABLE, text_in
from ._lines import LineFinder
from ._table import KeyFault, Table

T = TypeVar("T")


def text_of(path: Path, wanted: str, folder: Path | None = None) -> str:
    """Read a text file that is written by hand. wanted: for messages, such as "a .toml file".

    Errors: InputError, as `text_in`.
    """
    return text_in(path, attrs.evolve(TABLE, what=wanted), folder)


def parsed(text: str, path: Path | str, made_of: Callable[[Table], T], example: str = "") -> T:
    """Parse TOML and return the result of `made_of`; refuse keys that it did not read.

    path: for messages. Errors: InputError naming file, line and value.
    """
    try:
        table = Table(parse_toml(text), example=example)
    except DocumentError as error:
        place = path if error.line is None else f"{path}:{error.line}"
        raise InputError(f"{place}: this is no TOML: {error}{_several(str(error))}") from error
    try:
        made = made_of(table)
        table.refuse_unread()
    except KeyFault as error:
        said = " ".join(str(error).split())  # names and texts of a file may hold line ends
        raise InputError(f"{path}:{LineFinder(text).line(error.path)}: {said}") from error
    return made


def _several(says: str) -> str:
    """Suggest [[key]] for [key] written twice."""
    found = re.fullmatch(r"Cannot declare \((.*)\) twice(?: \(column \d+\))?", says)
    if found is None:
        return ""
    key = ".".join(part.strip().strip("'\"") for part in found[1].split(",") if part.strip())
    return f"; where a file may have several of them, each begins with [[{key}]]"
