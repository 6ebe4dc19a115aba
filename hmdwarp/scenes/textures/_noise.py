"""Noise and colours that the painted textures are made of."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

Image = NDArray[np.uint8]  # (h, w, 3 or 4), top row first
Field = NDArray[np.floating]  # (h, w)


@cache
def fractal(
    height: int, width: int, seed: int, exponent: float = 1.0, stretch: tuple[float, float] = (1.0, 1.0)
) -> NDArray[np.float32]:
    """Return tiling noise (height, width) with mean 0 and deviation 1.

    exponent: of the frequency; 0 is white, 1 pink, 2 smooth noise. stretch: factors down and
    across.
    """
    white = np.random.default_rng(seed).standard_normal((height, width), dtype=np.float32)
    fy = np.fft.fftfreq(height)[:, None] * height * stretch[0]
    fx = np.fft.rfftfreq(width)[None] * width * stretch[1]
    amplitude = np.maximum(np.hypot(fy, fx), 1.0) ** -exponent
    amplitude[0, 0] = 0
    field = np.fft.irfft2(np.fft.rfft2(white) * amplitude, s=(height, width)).astype(np.float32)
    field /= field.std()
    field.flags.writeable = False
    return field


def to_image(colour: NDArray) -> Image:
    """Convert (h, w, 3 or 4) sRGB values of 0..1 to bytes."""
    return (np.clip(colour, 0, 1) * 255 + 0.5).astype(np.uint8)


def tinted(value: Field, dark: ArrayLike, bright: ArrayLike) -> NDArray:
    """Return (h, w, 3) sRGB between two colours, by a field of 0..1."""
    low, high = np.asarray(dark, np.float32), np.asarray(bright, np.float32)
    return low + np.clip(value, 0, 1)[..., None] * (high - low)


def unit_grid(height: int, width: int) -> tuple[Field, Field]:
    """Return (h, w) places y and x from 0 at the top left towards 1."""
    y, x = np.meshgrid(np.arange(height) / height, np.arange(width) / width, indexing="ij")
    return y, x
