"""Files of cases on their way to other machines: each crosses once, and is known by its content."""

from __future__ import annotations

import os
import pickle
import uuid
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import attrs

from ...errors import InputError
from .identity import HOW, files_at, hash_of_files, is_place

MOST_BYTES = 1 << 30  # of one trace, or of a scene with its textures
_MARK = "hmdwarp-file:"


def packed(value: Any, carry: Callable[[str, Path], None]) -> Any:
    """Return options in which marks stand for files; carry(hash, place) is called for each.

    Folders stay as they are: recorded frames are read where they lie, from a file system that all
    machines share. Errors: InputError for files that are too large to cross.
    """

    def mark(text: str | Path) -> str | Path:
        if not is_place(text) or Path(text).is_dir():
            return text
        found = hash_of_files(text)
        carry(found, Path(text))
        marked = f"{_MARK}{found}/{Path(text).name}"
        return Path(marked) if isinstance(text, Path) else marked

    return _mapped(value, mark)


def unpacked(value: Any, folders: Mapping[str, Path]) -> Any:
    """Return options with the places of the files; folders: where each hash was unpacked."""

    def place(text: str | Path) -> str | Path:
        if not str(text).startswith(_MARK):
            return text
        found, _, name = str(text).removeprefix(_MARK).partition("/")
        path = folders[found] / name
        return path if isinstance(text, Path) else str(path)

    return _mapped(value, place)


def bytes_of(place: Path) -> bytes:
    """Return the files that a place stands for, as bytes that `unpack` reads.

    Errors: InputError for more than MOST_BYTES.
    """
    files = files_at(place)
    if (total := sum(one.stat().st_size for one in files)) > MOST_BYTES:
        raise InputError(
            f"{place}: {total / 1e6:.0f} MB with the files that it names, at most {MOST_BYTES / 1e6:.0f} cross to "
            "other machines: use a smaller one"
        )
    return pickle.dumps({one.relative_to(place.parent).as_posix(): one.read_bytes() for one in files})


def unpack(content: bytes, folder: Path) -> Path:
    """Write what bytes_of returned into a folder that is made, unless it is there; return it."""
    if not folder.is_dir():
        made = folder.with_name(f".{folder.name}-{uuid.uuid4().hex[:8]}")
        for name, data in pickle.loads(content).items():
            path = made / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)
        try:
            made.rename(folder)
        except OSError:  # another worker was first
            if not folder.is_dir():
                raise
    return folder


def _mapped(value: Any, change: Callable[[str | Path], str | Path]) -> Any:
    if attrs.has(type(value)):
        old = {one.name: getattr(value, one.name) for one in attrs.fields(type(value)) if one.name not in HOW}
        new = {name: _mapped(one, change) for name, one in old.items()}
        changed = {name: one for name, one in new.items() if one is not old[name]}
        return attrs.evolve(value, **changed) if changed else value
    if isinstance(value, tuple | list):
        mapped = [_mapped(one, change) for one in value]
        return value if all(a is b for a, b in zip(value, mapped, strict=True)) else type(value)(mapped)
    if isinstance(value, str | os.PathLike):
        return change(value)  # type: ignore[arg-type]
    return value
