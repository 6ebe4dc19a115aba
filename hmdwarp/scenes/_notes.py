"""Notes on a foreign file, and the files that it names."""

from __future__ import annotations

from pathlib import Path, PurePosixPath
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from ..options.named_files import BESIDE, content_of


class Notes:
    """Gathers what was left out or replaced; the same thing twice is one line with a count."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._examples: dict[str, list[str]] = {}

    def add(self, what: str, example: str = "") -> None:
        """Note a fact. example: where it was met, which one line of many names."""
        found = self._examples.setdefault(what, [])
        if example not in found:
            found.append(example)

    def lines(self) -> list[str]:
        """Return one line for each fact, in the order in which they were first met."""
        lines = []
        for what, (first, *more) in self._examples.items():
            several = f"{len(more) + 1} of them, such as " if more else ""
            lines.append(f"{self._path.name}: {what}" + (f": {several}{first}" if first else ""))
        return lines


_NETWORK = ("http:", "https:", "ftp:")


def rgba_of(image: Any) -> NDArray[np.uint8]:
    """Return (h, w, 4) bytes of a PIL image; 16 bits of grey are scaled, not clipped."""
    from PIL import Image

    if image.mode.startswith("I"):
        image = Image.fromarray(np.rint(np.clip(np.asarray(image), 0, 65535) / 257).astype(np.uint8))
    return np.array(image.convert("RGBA"))


def read_beside(folder: Path, uri: str) -> bytes:
    """Return the bytes of the file that a URI names next to a scene file.

    Exporters write backslashes, another case than the disk, and queries: they are followed.
    Errors: OSError with the reason in plain words; FileNotFoundError for none; InputError, as
    content_of.
    """
    if uri.lower().startswith(_NETWORK):
        raise OSError("it is on the network; download it, and name the copy")
    names = [uri, unquote(uri), unquote(uri.partition("?")[0].partition("#")[0])]
    names += [name.replace("\\", "/") for name in names]
    names = [name.removeprefix("file://") for name in dict.fromkeys(names) if "\0" not in name]
    whole = next((folder / name for name in names if _is_file(folder / name)), None)
    found = [whole] if whole is not None else _in_any_case(folder, names)
    if len(found) > 1:
        raise OSError(f"{len(found)} files have that name in upper and lower case; rename the others")
    if found:
        return content_of(found[0], BESIDE, folder)
    if any((folder / name).is_dir() for name in names):
        raise OSError("it is a folder; name a file")
    raise FileNotFoundError("there is no such file; put it beside the scene file")


def _is_file(path: Path) -> bool:
    """Return whether there is anything but a folder, which content_of looks at."""
    return path.exists() and not path.is_dir()


def _in_any_case(folder: Path, names: list[str]) -> list[Path]:
    """Return the files under the first of the names that fits but for case."""
    for name in names:
        places = [Path("/") if name.startswith("/") else folder]
        for part in PurePosixPath(name).parts:
            places = [path for place in places for path in _called(place, part)]
        if found := [place for place in places if _is_file(place)]:
            return found
    return []


def _called(place: Path, part: str) -> list[Path]:
    if part in ("..", "/"):
        return [place / part]
    try:
        return [path for path in place.iterdir() if path.name.casefold() == part.casefold()]
    except OSError:
        return []
