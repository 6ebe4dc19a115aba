"""Read and parse whole files; errors name the line: `study.toml:14: trial.order is ..`."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from ...errors import InputError
from ._lines import LineFinder
from ._table import KeyFault, Table

T = TypeVar("T")
_MOST_BYTES = 1_000_000  # these files are written by hand; a larger one is another kind of file


def text_of(path: Path, wanted: str) -> str:
    """Read a text file, with LF line ends and without a byte order mark.

    wanted: for messages, such as "a .toml file". Errors: InputError.
    """
    try:
        data = path.read_bytes()
    except (OSError, ValueError) as error:  # a name with a zero byte is a ValueError
        raise InputError(f"{path}: {getattr(error, 'strerror', None) or error}: expected {wanted}") from error
    if len(data) > _MOST_BYTES:
        raise InputError(f"{path}: {len(data)} bytes: expected {wanted}, of at most {_MOST_BYTES} bytes")
    try:
        return data.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise InputError(f"{path}:{line}: byte {data[error.start]:#x}: expected {wanted}, in UTF-8") from error


def parsed(text: str, path: Path | str, made_of: Callable[[Table], T], example: str = "") -> T:
    """Parse TOML and return the result of `made_of`; refuse keys that it did not read.

    path: for messages. Errors: InputError naming file, line and value.
    """
    try:
        table = Table(tomllib.loads(text), example=example)
    except (ValueError, RecursionError) as error:
        raise InputError(_not_toml(path, str(error))) from error
    try:
        made = made_of(table)
        table.refuse_unread()
    except KeyFault as error:
        said = " ".join(str(error).split())  # names and texts of a file may hold line ends
        raise InputError(f"{path}:{LineFinder(text).line(error.path)}: {said}") from error
    return made


def _not_toml(path: Path | str, says: str) -> str:
    """Put tomllib's line number, if any, in front."""
    says = " ".join(says.split())
    found = re.fullmatch(r"(.*) \(at line (\d+), column (\d+)\)", says)
    if found is None:
        return f"{path}: this is no TOML: {says}"
    return f"{path}:{found[2]}: this is no TOML: {found[1]} (column {found[3]}){_several(found[1])}"


def _several(says: str) -> str:
    """Suggest [[key]] for [key] written twice."""
    found = re.fullmatch(r"Cannot declare \((.*)\) twice", says)
    if found is None:
        return ""
    key = ".".join(part.strip().strip("'\"") for part in found[1].split(",") if part.strip())
    return f"; where a file may have several of them, each begins with [[{key}]]"
