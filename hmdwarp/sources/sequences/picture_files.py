"""Colour and depth in files: PNG, JPEG, PGM, TIFF, EXR and NPY. Row 0 is the top row."""

from __future__ import annotations

import io
import math
import os
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...base import InputError, as_path, import_extra, pyav
from ...base.named_files import MOST_PIXELS_BYTES, PICTURE_FILE, VIDEO, opened

EXR, NPY = ".exr", ".npy"
PICTURES = (".png", ".jpg", ".jpeg", ".pgm", ".ppm", ".tif", ".tiff", ".webp")
_DEEP, _FULL = ("I;16", "I;16B", "I;16L", "I", "F"), 65535
Size = tuple[int, int]


def read_colour(path: Path) -> NDArray[Any]:
    """Return the colour of a picture.

    Returns
    -------
    array
        (h, w, 3), or (h, w, 4) with alpha: uint8 sRGB, or float32 linear light of EXR.

    Raises
    ------
    InputError
        For what is no colour picture.
    """
    path = as_path(path)
    if path.suffix.lower() == EXR:
        return read_exr(path).colour()
    with _opened(path) as picture:
        if picture.mode in _DEEP:
            raise InputError(f"{path}: one channel of mode {picture.mode}, as depth has it; expected a colour picture")
        return np.asarray(picture.convert("RGBA" if picture.has_transparency_data else "RGB"))


def read_depth(path: Path) -> NDArray[Any]:
    """Return the depth of a picture, in its own units.

    Returns
    -------
    array
        (h, w) integers or floats. The largest of a PGM's own bits measures nothing: 65535.

    Raises
    ------
    InputError
        For what is no depth.
    """
    path = as_path(path)
    suffix = path.suffix.lower()
    if suffix == EXR:
        exr = read_exr(path)
        if (depth := exr.depth()) is None:
            raise InputError(f"{path}: channels {', '.join(exr.channels)}; expected depth in Depth.Z, Depth.V or Z")
        return depth
    if suffix == NPY:
        return read_npy(path)
    with _opened(path) as picture:
        if picture.mode not in _DEEP:
            expected = "expected depth in one channel of 16 bits or floats"
            raise InputError(f"{path}: a picture of mode {picture.mode}, 8 bits a channel; {expected}")
        values, most = np.asarray(picture), 0
        if picture.format == "PPM":  # the fourth word is the largest value that a PGM states
            with opened(path, PICTURE_FILE) as file:
                head = (line.partition(b"#")[0].split() for line in file.read(1000).splitlines())
                most = int([word for words in head for word in words][3])
    if values.dtype.kind == "f":
        return values
    if most and most != _FULL:  # Pillow has spread them over 16 bits
        values = (values.astype(np.int64) * most + _FULL // 2) // _FULL
        if not most & (most + 1):
            values[values == most] = _FULL
    return values.astype(np.uint16 if values.min() >= 0 and values.max() <= _FULL else np.int32)


def size_of(path: Path) -> Size:
    """Return (w, h) of a picture without reading its pixels. Errors: as read_colour."""
    if path.suffix.lower() == EXR:
        high, wide = next(iter(read_exr(path).channels.values())).shape
        return wide, high
    with _opened(path) as picture:
        wide, high = picture.size
        return wide, high


def fitted_depth(depth: NDArray[Any], colour: NDArray[Any], where: object) -> NDArray[Any]:
    """Return the nearest depth at the pixels of its colour. Errors: InputError: other shape."""
    (high, wide), (rows, columns) = colour.shape[:2], depth.shape
    if (high, wide) == (rows, columns):
        return depth
    if abs(wide / high - columns / rows) > 0.01 * wide / high:
        why = "of another shape: expected depth that is registered to the colour"
        raise InputError(f"{where}: colour has {wide}x{high} pixels, depth {columns}x{rows}, {why}")
    row, column = (((np.arange(n) + 0.5) * m / n).astype(int) for n, m in ((high, rows), (wide, columns)))
    return np.asarray(depth[row[:, None], column])


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    from PIL import Image

    with opened(path, PICTURE_FILE) as file:
        try:
            picture = Image.open(file)
        except Image.DecompressionBombError as error:
            raise InputError(f"{path}: too large a picture ({error})") from error
        except (OSError, ValueError, SyntaxError) as error:
            expected = f"expected {', '.join((*PICTURES, EXR))}, or {NPY} for depth"
            raise InputError(f"{path}: not a picture that can be read; {expected}") from error
        try:
            yield picture
        except (OSError, ValueError, SyntaxError, IndexError) as error:
            raise InputError(f"{path}: a damaged picture ({error})") from error


def read_npy(path: Path, *, channels: bool = False) -> NDArray[Any]:
    """Return (h, w) numbers, or (h, w, channels). Errors: InputError."""
    try:
        with opened(path, PICTURE_FILE) as file:
            values: Any = np.load(file, allow_pickle=False)
    except InputError:
        raise
    except Exception as error:  # NumPy and Python's tokenizer raise many kinds for a damaged head
        raise InputError(f"{path}: not an .npy file of numbers ({' '.join(str(error).split())})") from error
    shape, kind = getattr(values, "shape", ()), getattr(values, "dtype", None)
    fits = len(shape) == 3 if channels else len(shape) == 2 or shape[2:] == (1,)
    if not fits or kind is None or kind.kind not in "fiu":
        wanted = "(h, w, channels)" if channels else "(h, w)"
        raise InputError(f"{path}: {kind} {shape}; expected numbers of {wanted}")
    return np.asarray(values if channels else values.reshape(shape[:2]))


class VideoPictures:
    def __init__(self, path: Path) -> None:
        self.path = path
        self._lock = threading.Lock()
        self._next, self._pictures = 0, iter(())  # type: int, Iterator[Any]
        # Instants of the pictures that were decoded, by which one is found again.
        self._instants: list[int | None] = []
        self._last: tuple[int, NDArray[np.uint8]] | None = None
        self.size: Size = self.picture(0).shape[1::-1]

    def picture(self, number: int) -> NDArray[np.uint8]:
        """Return (h, w, 3) sRGB of a picture, counted from 0 as it is shown; quickest in order."""
        with self._lock:
            if self._last is None or self._last[0] != number:
                self._last = number, self._decoded(number)
            return self._last[1]

    def _decoded(self, number: int) -> NDArray[np.uint8]:
        av = pyav()

        try:
            if number < self._next or self._next == 0:
                # Begin at a picture that was decoded before, else with the first.
                instant = self._instants[number] if number < len(self._instants) else None
                self._next, self._pictures = (0 if instant is None else number), self._from(av, instant)
            for picture in self._pictures:
                if self._next == len(self._instants):
                    self._instants.append(picture.pts)
                elif self._instants[self._next] not in (None, picture.pts):  # it cannot be sought
                    self._next, self._instants = 0, [None] * len(self._instants)
                    return self._decoded(number)
                self._next += 1
                if self._next > number:
                    return np.asarray(picture.to_ndarray(format="rgb24"))
        except (OSError, av.FFmpegError) as error:
            raise InputError(f"{self.path}: not a video that can be read ({error})") from error
        raise InputError(f"{self.path}: {self._next} pictures; expected picture {number}, counted from 0")

    def _from(self, av: Any, instant: int | None) -> Iterator[Any]:
        # Of this form alone: playlists, for instance, name other files.
        with opened(self.path, VIDEO) as file, av.open(file, format="mp4") as container:
            if not container.streams.video:
                raise InputError(f"{self.path}: no pictures in it: expected a video")
            stream = container.streams.video[0]
            if instant is not None:
                # A second before: pictures just after a seek may need those before it.
                container.seek(max(0, instant - round(1 / stream.time_base)), stream=stream)
            pictures = container.decode(stream)
            yield from pictures if instant is None else (shown for shown in pictures if shown.pts >= instant)


FAR_M = 1e9  # renderers write a large number where nothing was hit: Blender 1e10, others the largest float
_COLOUR = ("R", "G", "B")
_SOLE = ("R", "V", "Y", "Z")  # what a file of one channel calls its values
_NO_COLOUR = ("depth", "z", "n", "normal", "p", "position", "vector", "velocity", "motion", "uv", "mist")
# A display window larger than both is no picture's: what surrounds the pixels is filled with zeros.
_MOST_PIXELS, _MOST_AROUND = 2**24, 16
_turn = threading.Lock()


def _last(layer: str) -> str:
    return layer.rpartition(".")[2].lower()


@attrs.frozen(eq=False)
class _ExrPicture:
    """The channels of an EXR file over its display window, by name; row 0 is the top row."""

    path: Path
    channels: dict[str, NDArray[np.float32]]
    views: tuple[str, ...]  # names of views among those of layers; the first is that of channels without one

    def _layers(self) -> dict[tuple[str, str], dict[str, str]]:
        found: dict[tuple[str, str], dict[str, str]] = {}
        for name in self.channels:
            *words, last = name.split(".")
            view = next((word for word in words if word in self.views), self.views[0])
            layer = ".".join(word for word in words if word not in self.views)
            found.setdefault((view, layer), {})[last] = name
        return found

    def _of_colour(self) -> list[tuple[str, str]]:
        found = [
            key for key, own in self._layers().items() if {*_COLOUR} <= own.keys() and _last(key[1]) not in _NO_COLOUR
        ]
        found = [key for key in found if not key[1]] or [key for key in found if _last(key[1]) == "combined"] or found
        return [key for key in found if key[0] == self.views[0]] or found

    def colour(self) -> NDArray[np.float32]:
        if len(found := self._of_colour()) != 1:
            several = ", ".join(self._layers()[key]["R"].removesuffix(".R") for key in found)
            raise InputError(
                f"{self.path}: colour in several layers ({several}); expected one"
                if found
                else f"{self.path}: channels {', '.join(self.channels)}; expected R, G and B of one layer"
            )
        own = self._layers()[found[0]]
        rgb = np.stack([self.channels[own[name]] for name in _COLOUR], axis=2)
        if "A" not in own:
            return rgb
        alpha = np.clip(self.channels[own["A"]], 0, 1)  # the light is premultiplied by it
        return np.concatenate([rgb / np.where(alpha > 0, alpha, 1)[..., None], alpha[..., None]], axis=2)

    def depth(self) -> NDArray[np.float32] | None:
        """Return (h, w) in the file's units, inf beyond FAR_M, or None. Errors: InputError."""
        view, beside = next(iter(self._of_colour()), ("", ""))
        found: list[tuple[int, str, str, str]] = []
        for (of, layer), own in self._layers().items():
            for last, name in own.items():
                is_z = last.lower() == "z" and layer in ("", beside, beside.rpartition(".")[0])
                if last.lower() == "depth" or _last(layer) == "depth" and last != "A":
                    found.append((0, layer, of, name))
                elif is_z or _last(layer) == "z" or len(self.channels) == 1 and name in _SOLE:
                    found.append((1, layer, of, name))
        if found and view and not (same := [one for one in found if one[2] == view]):
            why = f"depth of another ({', '.join(one[3] for one in found)}); expected both of one"
            raise InputError(f"{self.path}: colour of the view {view}, {why}")
        found = same if found and view else found
        named = [one for one in found if one[0] == min(found)[0]]
        named = [one for one in named if one[1].rpartition(".")[0] == beside.rpartition(".")[0]] or named
        if any((self.channels[one[3]] != self.channels[named[0][3]]).any() for one in named[1:]):
            why = f"depth in several channels ({', '.join(one[3] for one in named)}); expected one"
            raise InputError(f"{self.path}: {why}")
        if not named:
            return None
        depth = self.channels[named[0][3]]
        return np.where(depth > FAR_M, np.float32(np.inf), depth)


def read_exr(path: Path) -> _ExrPicture:
    """Return what an EXR file holds. Errors: InputError; MachineError without its package."""
    library: Any = import_extra("OpenEXR", "OpenEXR", "exr")
    damage: list[str] = []
    try:
        with opened(path, PICTURE_FILE) as plain, _printed_to(damage):
            name = f"/proc/self/fd/{plain.fileno()}"  # for what opens by name alone: this very file
            with library.File(name, header_only=True) as file:  # what its pixels are, before any are read
                (left, top), (right, bottom) = file.header()["dataWindow"]
                count = (int(right) - int(left) + 1) * (int(bottom) - int(top) + 1) * len(file.header()["channels"])
            if 4 * count > MOST_PIXELS_BYTES:
                raise InputError(f"{path}: {4 * count} bytes of pixels, unpacked; expected at most {MOST_PIXELS_BYTES}")
            with library.File(name, separate_channels=True) as file:
                parts = len(file.parts)
                head, channels = dict(file.header()), {name: one.pixels for name, one in file.channels().items()}
    except InputError:
        raise
    except Exception as error:  # the library raises RuntimeError, OSError and its own for damaged files
        raise InputError(f"{path}: not an EXR file that can be read ({[*damage, error][0]})") from error
    if damage:
        raise InputError(f"{path}: not an EXR file that can be read ({damage[0]})")
    if parts > 1:
        raise InputError(f"{path}: {parts} parts; expected one: write a file of one part")
    if "deep" in str(head.get("type", "")).lower():
        raise InputError(f"{path}: deep pixels; expected one value for each: flatten it")
    placed = {name: _placed(path, head, pixels) for name, pixels in channels.items()}
    return _ExrPicture(path, placed, tuple(head.get("multiView", ())) or ("main", "left", "right"))


def write_exr(path: Path, colour: NDArray[Any], coverage: NDArray[Any], depth_m: NDArray[Any]) -> None:
    """Write light, not premultiplied, coverage in halves, and depth as Z, NaN for none."""
    library: Any = import_extra("OpenEXR", "OpenEXR", "exr")
    alpha = np.clip(coverage, 0, 1)
    half = np.finfo(np.float16)
    rgb = np.clip(colour * alpha[..., None], half.min, half.max).astype(np.float16)
    channels = {name: np.ascontiguousarray(rgb[..., i]) for i, name in enumerate(_COLOUR)}
    channels |= {"A": alpha.astype(np.float16), "Z": np.ascontiguousarray(depth_m, np.float32)}
    head = {"compression": library.ZIP_COMPRESSION, "type": library.scanlineimage}
    library.File(head, channels).write(str(path))


@contextmanager
def _printed_to(damage: list[str]) -> Iterator[None]:
    """Hold what the library prints of damage: to standard error, and as a warning."""
    with _turn, tempfile.TemporaryFile() as held, redirect_stdout(io.StringIO()) as printed:
        kept = os.dup(2)
        os.dup2(held.fileno(), 2)
        try:
            yield
        finally:
            os.dup2(kept, 2)
            os.close(kept)
            held.seek(0)
            for line in held.read().splitlines(keepends=True):
                if b"EXR_ERR" in line:
                    damage.append(" ".join(line.decode(errors="replace").rpartition(") ")[2].split()))
                else:
                    os.write(2, line)  # of another thread meanwhile
            if not damage and "Exception raised" in printed.getvalue():
                damage.append("pixels are missing")


def _placed(path: Path, head: dict[str, Any], pixels: NDArray[Any]) -> NDArray[np.float32]:
    (low, high), (left_top, right_bottom) = head["dataWindow"], head["displayWindow"]
    size = (np.asarray(right_bottom) - np.asarray(left_top) + 1)[::-1]
    wanted = (np.asarray(high) - np.asarray(low) + 1)[::-1]
    if pixels.shape != tuple(wanted):
        raise InputError(f"{path}: a channel of {pixels.shape[1]}x{pixels.shape[0]} in a window of another size")
    if pixels.shape == tuple(size) and tuple(low) == tuple(left_top):
        return pixels.astype(np.float32)
    if min(size) < 1 or math.prod(map(int, size)) > max(_MOST_PIXELS, _MOST_AROUND * pixels.size):
        raise InputError(f"{path}: a display window of {size[1]}x{size[0]} around {wanted[1]}x{wanted[0]} pixels")
    whole = np.zeros(tuple(size), np.float32)
    row, column = (int(a - b) for a, b in zip(low[::-1], left_top[::-1], strict=True))
    rows, columns = (
        slice(max(0, at), max(0, min(at + n, m))) for at, n, m in zip((row, column), pixels.shape, size, strict=True)
    )
    whole[rows, columns] = pixels[rows.start - row : rows.stop - row, columns.start - column : columns.stop - column]
    return whole
