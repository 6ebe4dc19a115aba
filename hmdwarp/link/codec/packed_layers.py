"""What is packed without loss: layers, holes, and light as bytes."""

from __future__ import annotations

import functools
import math
import struct
import zlib
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ...colour import linear_from_srgb, srgb8_from_linear, srgb_from_linear
from .stream import Undecodable

_LEVEL = 1  # level 6 takes 10 times as long to save another tenth
_MOST_AXES = 8


def pack(layer: NDArray[Any]) -> bytes:
    """Pack (n,), (h, w) or (h, w, channels) of any number type without loss.

    Each byte of a value is coded as its difference from that of the pixel before, equal bytes of
    all pixels together. zlib runs twice, because one run cannot make less than 1/1032 of its input
    and a mask is mostly one value.
    """
    layer = np.ascontiguousarray(layer)
    kind = layer.dtype.str.encode()
    head = struct.pack(f"<B{len(kind)}sB{layer.ndim}I", len(kind), kind, layer.ndim, *layer.shape)
    if layer.size == 0:
        return zlib.compress(head)
    pixels = layer.reshape(math.prod(layer.shape[:2]), -1).view(np.uint8)
    changes = pixels.copy()
    changes[1:] -= pixels[:-1]
    # Differences come in runs, and a few values dominate; a search for repeated patterns does not
    # pay.
    coder = zlib.compressobj(_LEVEL, zlib.DEFLATED, zlib.MAX_WBITS, 9, zlib.Z_RLE)
    once = coder.compress(np.ascontiguousarray(changes.T).data) + coder.flush()
    return zlib.compress(head + once, _LEVEL)


def unpack(data: bytes) -> NDArray[Any]:
    """Return what `pack` was given. Errors: Undecodable for damaged bytes."""
    try:
        whole = zlib.decompress(data)
        length = whole[0]
        kind, axes = np.dtype(whole[1 : 1 + length].decode()), whole[1 + length]
        if axes > _MOST_AXES:
            raise ValueError(f"{axes} axes")
        shape = struct.unpack_from(f"<{axes}I", whole, 2 + length)
        if math.prod(shape) == 0:
            return np.zeros(shape, kind)
        changes = np.frombuffer(zlib.decompress(whole[2 + length + 4 * axes :]), np.uint8)
        pixels = np.cumsum(changes.reshape(-1, math.prod(shape[:2])), axis=1, dtype=np.uint8)
        return np.ascontiguousarray(pixels.T).view(kind).reshape(shape)
    except (zlib.error, struct.error, IndexError, TypeError, ValueError) as error:
        raise Undecodable(f"damaged packed layer ({error})") from error


# Powers of 2 that light beyond 1 may reach; half floats end before the last.
STOPS = (0, 1, 2, 4, 8, 16)
# Of a picture with light beyond 1, the byte that 1 becomes: three quarters are left for what is
# below.
_ONE = 191


def stops_of(light: NDArray[np.float16]) -> int:
    """Return how many powers of 2 above 1 the bytes must reach for this light, one of STOPS."""
    largest = float(light.max(initial=0, where=np.isfinite(light)))
    return next(stops for stops in STOPS if largest <= 2.0**stops)


def bytes_from_light(light: NDArray[np.float16], stops: int) -> NDArray[np.uint8]:
    """Return the bytes of linear light: sRGB if stops is 0, and light beyond 1 is clipped.

    Else sRGB up to 1, in the lower three quarters of the bytes, and equal ratios from there to
    2^stops. Negative light and NaN become 0.
    """
    return srgb8_from_linear(light) if stops == 0 else _byte_of_half(stops)[light.view(np.uint16)]


def light_from_bytes(values: NDArray[np.uint8], stops: int) -> NDArray[np.float16]:
    """Return the linear light of bytes; the reverse of bytes_from_light."""
    return _half_of_byte(stops)[values]


@functools.cache
def _half_of_byte(stops: int) -> NDArray[np.float16]:
    values = np.arange(256)
    if stops == 0:
        return linear_from_srgb(values.astype(np.uint8)).astype(np.float16)
    below = linear_from_srgb(np.minimum(values / _ONE, 1))
    beyond = 2.0 ** (stops * (values - _ONE) / (255 - _ONE))
    return np.minimum(np.where(values <= _ONE, below, beyond), np.finfo(np.float16).max).astype(np.float16)


@functools.cache
def _byte_of_half(stops: int) -> NDArray[np.uint8]:
    with np.errstate(invalid="ignore"):  # the table's own NaN entries
        light = np.nan_to_num(np.arange(65536, dtype=np.uint16).view(np.float16).astype(np.float64), nan=0.0)
    beyond = _ONE + (255 - _ONE) * np.log2(np.clip(light, 1, 2.0**stops)) / stops
    return np.floor(np.where(light <= 1, _ONE * srgb_from_linear(light), beyond) + 0.5).astype(np.uint8)


T = TypeVar("T", np.uint8, np.uint16)


def covered(colour: NDArray[T], hole: NDArray[np.bool_]) -> NDArray[T]:
    """Return the picture with each hole coloured like the covered pixel before it in its row.

    At the start of a row, like the first covered one after it; a row of holes like the one before
    it, or the first that has any. A black hole would bleed into neighbouring pixels, through the
    codec's blocks and half-resolution chroma, and cost bytes. The decoder clears the holes again.
    Without holes, and with nothing else, the picture itself is returned.
    """
    if not hole.any() or hole.all():
        return colour
    across = np.take_along_axis(colour, _nearest(hole)[..., None], axis=1)
    rows: NDArray[np.bool_] = np.all(hole, axis=1)
    return across[_nearest(rows[None])[0]] if rows.any() else across


def _nearest(hole: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Return the column that each pixel of (h, w) takes its colour from; 0 in a row of holes."""
    columns = np.where(hole, -1, np.arange(hole.shape[1], dtype=np.int32))
    before = np.maximum.accumulate(columns, axis=1)
    first = np.argmin(hole, axis=1)
    return np.where(before < 0, first[:, None], before)
