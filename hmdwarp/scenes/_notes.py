"""Notes on a foreign file: what was left out, and what its data say of its units and axes."""

from __future__ import annotations

from pathlib import Path, PurePosixPath
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError
from ..options.named_files import BESIDE, content_of
from ._viewpoint import Triangles


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


Array = NDArray[np.float64]
# Larger than a hall, which is rarely meant in metres; and smaller than a head moves, which goes
# past it or through it.
_LARGE_M, _SMALL_M = 50.0, 0.2
# What a file in these units may hold: from a thing in the hand to a hall.
_UNITS = (("a centimetre", 0.01), ("a millimetre", 0.001))
_LIKELY_M = 0.05, 50.0
# Beyond it squares of distances and inverse depths leave float32.
_LARGEST_M = 1e9
_LARGEST_SCALE = 1e6  # the most that --scene-scale takes
_GROUND_SHARE, _THIN, _LEAST_THICK = 0.3, 0.02, 0.05


def add_hints(triangles: Triangles, low: Array, high: Array, scale: float, up: str, notes: Notes) -> None:
    """Note an extent that is rarely meant in metres, and a ground below the z axis.

    low, high: corners of the scene in metres with +y up. scale, up: as the options have them.
    """
    size = float((high - low).max())
    if scale == 1 and size > _LARGE_M:
        fits = [unit for unit in _UNITS if _LIKELY_M[0] <= unit[1] * size <= _LIKELY_M[1]] or _UNITS[-1:]
        units = " or ".join(
            f"{name}, --scene-scale {metres:g} makes it {_metres(metres * size)}" for name, metres in fits
        )
        notes.add(f"{_metres(size)} across; if its unit is {units}")
    if scale == 1 and size < _SMALL_M:
        larger = min(10 ** round(-np.log10(size)), _LARGEST_SCALE)
        notes.add(
            f"{_metres(size)} across, and a head moves farther;"
            f" --scene-scale {larger:g} makes it {_metres(larger * size)}"
        )
    if up == "y" and _stands_on_z(triangles, low, high):
        notes.add("its ground lies below the z axis, not the y axis; if z is up, use --scene-up z")


def check_size(path: Path, low: Array, high: Array) -> None:
    """Refuse a scene too large for float32: SceneError. low, high: corners in metres."""
    size = float((high - low).max())
    if size > _LARGEST_M:
        raise SceneError(
            f"{path}: {size:.3g} m across; expected at most {_LARGEST_M:.0e} m: say what its unit is by"
            " --scene-scale, or export it again"
        )


def _metres(metres: float) -> str:
    """Return a length in metres to three digits, in powers of ten only where zeros abound."""
    return f"{float(f'{metres:.3g}'):.15g} m" if 1e-4 <= metres < 1e7 else f"{metres:.3g} m"


def _stands_on_z(triangles: Triangles, low: Array, high: Array) -> bool:
    """Return whether there is a ground at the lowest z and none at the lowest y.

    In a room both have one, and its ceiling is the nearer: then what stands in it must lie low.
    """
    size = high - low
    if size[2] < _LEAST_THICK * size[:2].max():
        return False  # a picture on a wall
    grounds = [_ground_share(triangles, low, high, axis) for axis in (1, 2)]
    if grounds[1] < _GROUND_SHARE:
        return False
    if grounds[0] < _GROUND_SHARE:
        return True
    # The mean height of all surfaces, by area, as a share of the scene's.
    area = np.linalg.norm(triangles.crosses, axis=1)[:, None]
    above = (area * ((triangles.a + triangles.b + triangles.c) / 3 - low)).sum(axis=0)
    _, mass_y, mass_z = above / np.maximum(area.sum() * size, 1e-30)
    return bool(size[2] < 0.75 * min(size[0], size[1]) and mass_z < 0.45 and mass_y >= 0.45)


def _ground_share(triangles: Triangles, low: Array, high: Array, axis: int) -> float:
    """Return the share of the scene's outline, seen along an axis, that a flat ground covers."""
    size = high - low
    across = np.delete(size, axis)
    cross = triangles.crosses
    length = np.linalg.norm(cross, axis=1)
    heights = np.max([triangles.a[:, axis], triangles.b[:, axis], triangles.c[:, axis]], axis=0)
    flat = (np.abs(cross[:, axis]) > 0.95 * length) & (heights <= low[axis] + _THIN * size[axis])
    return float(0.5 * np.abs(cross[flat, axis]).sum() / max(float(across.prod()), 1e-30))


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
