"""OpenEXR files by the optional package OpenEXR: colour in linear light, coverage, and depth."""

from __future__ import annotations

import io
import math
import os
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from pathlib import Path
from typing import Any, BinaryIO

import attrs
import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ...options.named_files import PICTURE_FILE, opened
from ...resources import import_extra

# Renderers write a large number where nothing was hit: Blender 1e10, others the largest float.
FAR_M = 1e9
_COLOUR = ("R", "G", "B")
# A display window larger than both is no picture's: what surrounds the pixels is filled with zeros.
_MOST_PIXELS, _MOST_AROUND = 2**24, 16
_turn = threading.Lock()


@attrs.frozen(eq=False)
class ExrPicture:
    """What an EXR file holds, over its display window; row 0 is the top row."""

    # (h, w, 3) or (h, w, 4) float32, linear light with coverage; None without R, G and B.
    colour: NDArray[np.float32] | None
    # (h, w) float32 along -z in the file's units, inf beyond FAR_M; None without it.
    depth: NDArray[np.float32] | None
    shape: tuple[int, int]
    channels: tuple[str, ...]

    def need_colour(self, path: Path) -> NDArray[np.float32]:
        """Return the colour. Errors: InputError without it."""
        if self.colour is None:
            raise InputError(f"{path}: channels {', '.join(self.channels)}; expected R, G and B of one layer")
        return self.colour

    def need_depth(self, path: Path) -> NDArray[np.float32]:
        """Return the depth. Errors: InputError without it."""
        if self.depth is None:
            raise InputError(
                f"{path}: channels {', '.join(self.channels)}; expected depth in Z, or in a single channel"
            )
        return self.depth


def read_exr(path: Path) -> ExrPicture:
    """Return what an EXR file holds.

    A file of one channel is depth alone. Errors: InputError; MachineError without the optional
    package.
    """
    library = _library()
    damage: list[str] = []
    try:
        with (
            opened(path, PICTURE_FILE) as plain,
            _printed_to(damage),
            library.File(_by_number(plain), separate_channels=True) as file,
        ):
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
    shape = next(iter(placed.values())).shape
    group = _colour_group(path, placed)
    colour = None if group is None else _stack(placed, group)
    return ExrPicture(colour, _depth(path, placed), shape, tuple(placed))


def write_exr(path: Path, colour: NDArray[Any], coverage: NDArray[Any], depth_m: NDArray[Any]) -> None:
    """Write linear light and coverage as half floats, depth as Z in floats, NaN for none.

    colour: (h, w, 3), not premultiplied; the file's is, as EXR has it. Errors: MachineError without
    the optional package; OSError where the file cannot be written.
    """
    library = _library()
    alpha = np.clip(coverage, 0, 1)
    half = np.finfo(np.float16)
    rgb = np.clip(colour * alpha[..., None], half.min, half.max).astype(np.float16)
    channels = {name: np.ascontiguousarray(rgb[..., i]) for i, name in enumerate(_COLOUR)}
    channels |= {"A": alpha.astype(np.float16), "Z": np.ascontiguousarray(depth_m, np.float32)}
    head = {"compression": library.ZIP_COMPRESSION, "type": library.scanlineimage}
    library.File(head, channels).write(str(path))


def _by_number(file: BinaryIO) -> str:
    return f"/proc/self/fd/{file.fileno()}"  # for what opens by name alone: this very file


@contextmanager
def _printed_to(damage: list[str]) -> Iterator[None]:
    """Hold what the library prints of damage beside what it raises.

    Its core writes to standard error, its binding prints a warning.
    """
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


def _library() -> Any:
    return import_extra("OpenEXR", "OpenEXR", "exr")


def _placed(path: Path, head: dict[str, Any], pixels: NDArray[Any]) -> NDArray[np.float32]:
    """Return a channel over the whole display window, 0 where the data do not reach."""
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


def _colour_group(path: Path, channels: dict[str, NDArray[np.float32]]) -> str | None:
    """Return what stands before R, G and B: "" or a layer's name with its dot; None without."""
    groups = [
        name[:-1] for name in channels if name[-1] == "R" and all(name[:-1] + letter in channels for letter in _COLOUR)
    ]
    groups = [""] if "" in groups else [group for group in groups if group.endswith("Combined.")] or groups
    if len(groups) > 1:
        raise InputError(
            f"{path}: colour in several layers ({', '.join(group.rstrip('.') for group in groups)}); expected one"
        )
    return groups[0] if groups else None


def _stack(channels: dict[str, NDArray[np.float32]], group: str) -> NDArray[np.float32]:
    """Return the colour, divided by its alpha where there is any: EXR has it premultiplied."""
    rgb = np.stack([channels[group + name] for name in _COLOUR], axis=2)
    alpha = channels.get(group + "A")
    if alpha is None:
        return rgb
    alpha = np.clip(alpha, 0, 1)
    return np.concatenate([rgb / np.where(alpha > 0, alpha, 1)[..., None], alpha[..., None]], axis=2)


def _depth(path: Path, channels: dict[str, NDArray[np.float32]]) -> NDArray[np.float32] | None:
    names = [name for name in channels if name == "Z"] or [name for name in channels if name.endswith(".Z")]
    if len(names) > 1:
        raise InputError(f"{path}: depth in several channels ({', '.join(names)}); expected one")
    names = names or (list(channels) if len(channels) == 1 else [])
    if not names:
        return None
    depth = channels[names[0]]
    return np.where(depth > FAR_M, np.float32(np.inf), depth)
