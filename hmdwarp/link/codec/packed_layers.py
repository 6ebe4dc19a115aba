"""The code of layers that must arrive as they were drawn: masks, identities, points."""

from __future__ import annotations

import math
import struct
import zlib

import numpy as np
from numpy.typing import NDArray

from .undecodable import Undecodable

_LEVEL = 1  # level 6 takes 10 times as long to save another tenth
_MOST_AXES = 8


def pack(layer: NDArray) -> bytes:
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


def unpack(data: bytes) -> NDArray:
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
