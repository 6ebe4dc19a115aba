"""Linear light as bytes for a video codec, and back."""

from __future__ import annotations

import functools

import numpy as np
from numpy.typing import NDArray

from ...colour import linear_from_srgb, srgb8_from_linear, srgb_from_linear

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
