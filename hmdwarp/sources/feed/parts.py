"""What messages have besides their own numbers: further layers, wishes for them, hidden areas."""

from __future__ import annotations

import functools
import math
import re
import struct
import zlib
from collections.abc import Mapping, Sequence
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...geometry import Fov, Hidden
from . import bounds

Size = tuple[int, int]
Array = NDArray[Any]
Rows = tuple[tuple[float, ...], ...]

_WANTED = struct.Struct("<16sI")  # name of a layer, and how much of it
# Rows and columns of settings; they follow the list, of each layer whose amount there is 0.
_SETTINGS, _SETTING = struct.Struct("<HH"), struct.Struct("<d")
HEAD = struct.Struct("<16sBBBxIII")  # name of a layer, eye, format, whether it is packed, width, height, bytes
# By number of the format: how numbers are stored, and how many there are a pixel, or in one place
# of a table.
_KINDS = (("<f2", 4), ("<f4", 1), ("<u2", 1), ("<f8", 1), ("u1", 1))
FORMATS = dict(enumerate(((np.dtype(kind), count) for kind, count in _KINDS), 1))
TABLE, BYTES = 4, 5
_NAME = re.compile(rb"([a-z_]{1,16})\0*")
_LEVEL = 1


class BadPart(ValueError):
    """A part of a message that is none; the text says what is wrong with it."""


@attrs.frozen
class Wanted:
    """Which further layers a client reads, and the shown picture, whose size some of them have."""

    layers: tuple[tuple[str, int | Rows], ...]  # name of each, and how much of it: a number, or rows of settings
    size: Size  # (w, h) of the shown picture
    fovs: tuple[Fov, ...]  # of each eye's


@attrs.frozen(eq=False)
class Packed:
    format: int
    size: Size  # (w, h)
    data: bytes

    def numbers(self) -> Array:
        """Return what was packed. Errors: BadPart."""
        kind, shape = _shape(self.format, self.size)
        count = math.prod(shape) * kind.itemsize
        unpacking = zlib.decompressobj()
        try:
            found = unpacking.decompress(self.data, count + 1)
        except zlib.error as error:
            raise BadPart(f"a packed part is damaged ({error})") from error
        if len(found) != count or not unpacking.eof or unpacking.unused_data:
            raise BadPart(f"a packed part is not the {count} bytes that it says")
        return np.frombuffer(found, kind).reshape(shape)


Part = Array | Packed
Layers = Mapping[str, Sequence[Part]]  # the parts of each layer of one eye, in the order of its declaration


def packed(numbers: Array) -> Packed:
    found = format_of(numbers)
    stored = np.ascontiguousarray(numbers, FORMATS[found][0])
    return Packed(found, (numbers.shape[1], numbers.shape[0]), zlib.compress(stored.data, _LEVEL))


def format_of(numbers: Array) -> int:
    for found, (kind, channels) in FORMATS.items():
        if numbers.dtype == kind and numbers.shape[2:] == ((channels,) if channels > 1 else ()):
            return found
    raise ValueError(f"{numbers.dtype} of shape {numbers.shape}: no format of the feed")


def _shape(form: int, size: Size) -> tuple[np.dtype, tuple[int, ...]]:
    kind, channels = FORMATS[form]
    return kind, (size[1], size[0], channels) if channels > 1 else (size[1], size[0])


def length_of(part: Part) -> int:
    return len(part.data) if isinstance(part, Packed) else part.nbytes


def packed_wanted(wanted: Wanted) -> bytes:
    shown = [struct.pack("<4d", fov.left, fov.right, fov.down, fov.up) for fov in wanted.fovs]
    names = [_WANTED.pack(_coded(name), 0 if isinstance(how, tuple) else how) for name, how in wanted.layers]
    tables = [how for _, how in wanted.layers if isinstance(how, tuple)]
    rows = [_SETTINGS.pack(len(one), len(one[0])) + b"".join(map(_SETTING.pack, sum(one, ()))) for one in tables]
    return b"".join([struct.pack("<II", *wanted.size), *shown, *names, *rows])


def most_wanted_bytes(layers: int, eyes: int) -> int:
    settings = _SETTINGS.size + _SETTING.size * int(bounds.SETTINGS.most) ** 2
    return 8 + 32 * eyes + (_WANTED.size + settings) * layers


def wanted_from(data: bytes | memoryview, at: int, layers: int, eyes: int) -> tuple[Wanted | None, int]:
    """Return what a client reads, or None, and where it ends. Errors: ValueError, InputError."""
    if not layers:
        return None, at
    width, height = struct.unpack_from("<II", data, at)
    bounds.SIDE.check(width, height)
    fovs = tuple(fov_of(*struct.unpack_from("<4d", data, at + 8 + 32 * eye)) for eye in range(eyes))
    found: dict[str, int | Rows] = {}
    at += 8 + 32 * eyes
    for _ in range(layers):
        name, amount = _WANTED.unpack_from(data, at)
        bounds.AMOUNT.check(amount)
        found[_named(name)] = amount
        at += _WANTED.size
    if len(found) < layers:
        raise BadPart("a layer twice: expected each once")
    for name in [name for name, amount in found.items() if not amount]:
        rows, columns = _SETTINGS.unpack_from(data, at)
        bounds.SETTINGS.check(rows, columns)
        numbers = struct.unpack_from(f"<{rows * columns}d", data, at + _SETTINGS.size)
        found[name] = tuple(numbers[row * columns : (row + 1) * columns] for row in range(rows))
        at += _SETTINGS.size + _SETTING.size * rows * columns
    return Wanted(tuple(found.items()), (width, height), fovs), at


def fov_of(left: float, right: float, down: float, up: float) -> Fov:
    bounds.EXTENT.check(right - left, up - down)
    return Fov(left, right, down, up)


def packed_layers(layers: Sequence[Layers]) -> tuple[list[bytes], list[bytes | Array]]:
    heads: list[bytes] = []
    contents: list[bytes | Array] = []
    for eye, of_eye in enumerate(layers):
        for name, part in ((name, part) for name, several in of_eye.items() for part in several):
            form, size, content = (
                (part.format, part.size, part.data)
                if isinstance(part, Packed)
                else (format_of(part), (part.shape[1], part.shape[0]), part)
            )
            heads.append(HEAD.pack(_coded(name), eye, form, isinstance(part, Packed), *size, length_of(part)))
            contents.append(content)
    return heads, contents


def layers_from(
    data: bytes | memoryview, heads_at: int, count: int, at: int, eyes: int
) -> tuple[tuple[Layers, ...], int]:
    """Return each eye's layers, and where the message must end. Errors: BadPart."""
    found: tuple[dict[str, list[Part]], ...] = tuple({} for _ in range(eyes))
    for number in range(count):
        coded, eye, form, is_packed, wide, high, length = HEAD.unpack_from(data, heads_at + number * HEAD.size)
        name, size = _named(coded), (wide, high)
        is_empty, most = min(size) < 1 and form not in (TABLE, BYTES), bounds.UNPACKED if form == BYTES else bounds.SIDE
        if eye >= eyes or form not in FORMATS or max(size) > most.most or is_empty:
            raise BadPart(f"a part for eye {eye}, format {form}, {wide}x{high}: out of range")
        kind, shape = _shape(form, size)
        numbers = math.prod(shape)
        if at + length > len(data) or (not is_packed and length != numbers * kind.itemsize):
            raise BadPart(f"a part of {length} bytes: expected {numbers * kind.itemsize}")
        found[eye].setdefault(name, []).append(
            Packed(form, size, bytes(data[at : at + length]))
            if is_packed
            else np.frombuffer(data, kind, numbers, at).reshape(shape)
        )
        at += length
    return found, at


def unpacked_bytes(layers: Sequence[Layers]) -> int:
    every = (part for of_eye in layers for several in of_eye.values() for part in several)
    return sum(
        math.prod(_shape(part.format, part.size)[1]) * FORMATS[part.format][0].itemsize
        if isinstance(part, Packed)
        else part.nbytes
        for part in every
    )


def _coded(name: str) -> bytes:
    coded = name.encode("ascii")
    assert _NAME.fullmatch(coded), name
    return coded


def _named(coded: bytes) -> str:
    found = _NAME.fullmatch(coded)
    if found is None:
        raise BadPart(f"a layer called {coded!r}: expected a name of letters and underscores")
    return found[1].decode()


# What a lens hides of a view: the seen rows of a few columns.
_COLUMNS, _ROWS = 64, 255
AREA_BYTES = 2 * _COLUMNS  # of one eye
_FINE = (_COLUMNS * 8, _ROWS * 4)  # pixels over which the seen rows are found


@functools.lru_cache(maxsize=16)
def packed_area(hidden: Hidden | None, fov: Fov) -> bytes:
    """Return first seen row and end of each column, in 255ths from below; 0 and 0 where none is."""
    if hidden is None:
        return bytes([0, _ROWS]) * _COLUMNS
    rows = hidden.rows(fov, _FINE).reshape(_COLUMNS, -1, 2)
    seen = rows[..., 0] < rows[..., 1]
    first = np.where(seen, rows[..., 0], _FINE[1]).min(axis=1) // 4
    end = -(-rows[..., 1].max(axis=1) // 4)
    return np.where(seen.any(axis=1), [first, end], 0).T.astype(np.uint8).tobytes()


@functools.lru_cache(maxsize=64)
def area_from(data: bytes, fov: Fov) -> Hidden | None:
    """Return what AREA_BYTES hide, the same object for the same area. Errors: ValueError."""
    rows = np.frombuffer(data, np.uint8).reshape(_COLUMNS, 2).astype(np.int64)
    if (rows[:, 0] > rows[:, 1]).any() or not rows.any():
        raise ValueError("a hidden area leaves nothing to see, or ends before it begins")
    return None if (rows == (0, _ROWS)).all() else Hidden.of_rows(rows / _ROWS, fov)
