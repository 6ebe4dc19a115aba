"""A 16-bit code of inverse depth, packed without further loss: no pixel ever takes anything from its neighbours.

The code of a pixel: 0 is infinitely far, 65535 no depth, and k between them the inverse depths in ((k - 1) step, k step], decoded as
(k - 1/2) step. So what is infinitely far and what has no depth come back as such, nothing else does, and every other value within
step / 2. step is 2^-10 per metre, up to 64 per metre (16 mm from the eye); a picture with nearer things doubles it until they fit.

Equal steps of inverse depth, not of depth: an error of step / 2 moves a warped pixel by focal length * step / 2 * the way the eye
went, the same wherever the pixel is. At 700 pixels per unit of tangent and 0.2 m that is 0.07 pixels. And planes stay linear over the
picture, which the packing lives on: each code is foretold as left + below - below-left, which is right on planes but for rounding
and along edges that run with rows or columns; the differences, mod 2^16, are what zlib packs. To unpack is to sum up both ways.
"""

from __future__ import annotations

import struct
import zlib

import numpy as np
from numpy.typing import NDArray

from .errors import Undecodable
from .layers import deflated, inflated

STEP = 2.0**-10
_EXPONENT = -10
NO_DEPTH = 65535
_MOST = NO_DEPTH - 1
_HEADER = struct.Struct("<bxHH")  # exponent of the step, width, height
_LARGEST_SIDE = 65535


def encode_depth(inverse_depth: NDArray[np.float32]) -> bytes:
    """(h, w) float32 in 1/m; below 0 is no depth. The rows may run either way. Errors: ValueError for NaN or infinity."""
    codes, exponent = codes_of(inverse_depth)
    height, width = codes.shape
    if max(codes.shape) > _LARGEST_SIDE:
        raise ValueError(f"inverse depth of {width}x{height} pixels: wanted at most {_LARGEST_SIDE} a side")
    return _HEADER.pack(exponent, width, height) + deflated(_differences(codes))


def decode_depth(data: bytes) -> NDArray[np.float32]:
    """What `encode_depth` made, within half a step; no depth is -1. Errors: Undecodable for bytes that are damaged."""
    try:
        exponent, width, height = _HEADER.unpack_from(data)
        packed = inflated(data[_HEADER.size :], 2 * width * height)
    except (struct.error, zlib.error) as error:
        raise Undecodable(f"damaged depth ({error})") from error
    return inverse_depth_of(_summed(packed, (height, width)), exponent)


def codes_of(inverse_depth: NDArray[np.float32]) -> tuple[NDArray[np.uint16], int]:
    """The code of each pixel and the exponent of the step. Errors: as encode_depth."""
    values = np.asarray(inverse_depth, np.float32)
    largest = float(values.max(initial=0))
    if not np.isfinite(largest):
        raise ValueError(f"inverse depth {largest}: wanted finite numbers, below 0 for no depth")
    exponent = _EXPONENT
    while largest > _MOST * 2.0**exponent:
        exponent += 1
    codes = np.ceil(np.maximum(values, 0) * np.float32(2.0**-exponent)).astype(np.uint16)  # a power of 2: nothing is rounded
    if exponent > _EXPONENT:
        codes[(values > 0) & (codes == 0)] = 1  # what is too small for a float beside something extremely near
    codes[values < 0] = NO_DEPTH
    return codes, exponent


def inverse_depth_of(codes: NDArray[np.uint16], exponent: int) -> NDArray[np.float32]:
    """1/m of each code; -1 for no depth."""
    values = (codes.astype(np.float32) - np.float32(0.5)) * np.float32(2.0**exponent)
    values[codes == 0] = 0
    values[codes == NO_DEPTH] = -1
    return values


def _differences(codes: NDArray[np.uint16]) -> NDArray[np.uint8]:
    """From what is foretold, small ones of either sign as small numbers, the low bytes of all before the high ones."""
    left = codes.copy()
    left[:, 1:] -= codes[:, :-1]
    both = left.copy()
    both[1:] -= left[:-1]
    folded = (both << 1) ^ (both.view(np.int16) >> 15).view(np.uint16)  # 0, -1, 1, -2, .. to 0, 1, 2, 3, ..
    return np.concatenate([folded.astype(np.uint8).ravel(), (folded >> 8).astype(np.uint8).ravel()])


def _summed(packed: NDArray[np.uint8], shape: tuple[int, int]) -> NDArray[np.uint16]:
    """Undo `_differences`."""
    low, high = packed.reshape(2, *shape)
    folded = low | (high.astype(np.uint16) << 8)
    both = (folded >> 1) ^ -(folded & 1)
    return both.cumsum(axis=0, dtype=np.uint16).cumsum(axis=1, dtype=np.uint16)
