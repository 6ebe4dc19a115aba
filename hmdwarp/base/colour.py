"""Convert between linear light, used inside, and sRGB, used by files, windows and swapchains.

Source: IEC 61966-2-1:1999, with the constants of its amendment 1 (the rounded 0.0031308 and
0.04045).
"""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray


def _clipped(values: NDArray[Any]) -> NDArray[np.floating]:
    """Return floats 0..1, of float32 or float64; NaN is 0."""
    values = values if values.dtype == np.float32 else values.astype(np.float64)
    with np.errstate(invalid="ignore"):
        return np.where(values > 0, np.minimum(values, 1), 0).astype(values.dtype)


def srgb_from_linear(linear: ArrayLike) -> NDArray[np.floating]:
    """Return the sRGB encoding of linear light, both 0..1; clip the rest, turn NaN into 0 (black).

    Any shape; float32 in gives float32, everything else float64.
    """
    values = _clipped(np.asarray(linear))
    # In binary 1.055 - 0.055 is not quite 1, and white must stay white.
    curve = np.where(values < 1, 1.055 * values ** (1 / 2.4) - 0.055, 1)
    return np.where(values <= 0.0031308, 12.92 * values, curve).astype(values.dtype)


def linear_from_srgb(srgb: ArrayLike) -> NDArray[np.floating]:
    """Return the linear light, 0..1, of sRGB: uint8, or floats that are clipped, NaN is 0.

    uint8 gives float32, floats keep float32 or become float64.
    """
    values = np.asarray(srgb)
    if values.dtype == np.uint8:
        return np.asarray(_linear_of_byte()[values])
    values = _clipped(values)
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4).astype(values.dtype)


def srgb8_from_linear(linear: ArrayLike) -> NDArray[np.uint8]:
    """Return linear light 0..1 as sRGB bytes, rounded to the nearest; clipped, NaN becomes 0."""
    values = np.asarray(linear)
    if values.dtype == np.float16:  # of rgba16f textures: a table of all has the same bytes, 20 times faster
        return _byte_of_half()[values.view(np.uint16)]
    return _to_byte(srgb_from_linear(values))


def picture_from_linear(rgba: ArrayLike) -> NDArray[np.uint8]:
    """Return the (h, w, 3) sRGB picture of a linear (h, w, 4) image; holes (alpha 0) are black."""
    image = np.asarray(rgba)
    picture = srgb8_from_linear(image[..., :3])
    picture[image[..., 3] == 0] = 0
    return picture


def _to_byte(srgb: NDArray[np.floating]) -> NDArray[np.uint8]:
    return np.asarray(np.floor(srgb * 255 + 0.5), np.uint8)


@functools.cache
def _linear_of_byte() -> NDArray[np.float32]:
    return linear_from_srgb(np.arange(256) / 255).astype(np.float32)


@functools.cache
def _byte_of_half() -> NDArray[np.uint8]:
    with np.errstate(invalid="ignore"):  # the table's own NaN entries
        halves = np.arange(65536, dtype=np.uint16).view(np.float16).astype(np.float64)
    return _to_byte(srgb_from_linear(halves))
