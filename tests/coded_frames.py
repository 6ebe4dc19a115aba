"""Frames to be coded: textured surfaces in front of each other, moving, with holes and a sky."""

from __future__ import annotations

import numpy as np

from hmdwarp.colour import linear_from_srgb


def moving(size: tuple[int, int], count: int, *, holes: bool = True) -> list[tuple[np.ndarray, np.ndarray]]:
    """(colour (h, w, 3) uint8, inverse_depth (h, w) float32) of `count` instants.

    A slanted wall, a box passing before it, sky above.
    """
    width, height = size
    y, x = np.mgrid[:height, :width].astype(np.float64)
    out = []
    for k in range(count):
        colour = np.stack([128 + 60 * np.sin((x + 2 * k) / 9), 90 + y * 80 / height, 120 + 50 * np.cos(y / 7)], -1)
        inverse = 0.2 + 0.3 * x / width + 0.1 * y / height
        inverse[: height // 5] = 0
        colour[: height // 5] = (90, 150, 230)
        box = (abs(x - width / 3 - 2 * k) < width / 8) & (abs(y - height / 2) < height / 5)
        colour[box] = (220, 40, 30)
        inverse[box] = 1.5
        if holes:
            hole = (x - 0.8 * width) ** 2 + (y - 0.7 * height) ** 2 < (height / 9) ** 2
            colour[hole], inverse[hole] = 0, -1
        out.append((colour.astype(np.uint8), inverse.astype(np.float32)))
    return out


def rgba(colour: np.ndarray, inverse_depth: np.ndarray) -> np.ndarray:
    """(h, w, 4) half floats, linear light with coverage in alpha, of sRGB bytes; a hole is 0."""
    out = np.ones((*colour.shape[:2], 4), np.float16)
    out[..., :3] = linear_from_srgb(colour)
    out[inverse_depth < 0] = 0
    return out


def pictures(size: tuple[int, int], count: int) -> list[np.ndarray]:
    """The colours of `moving` as an encoder takes them."""
    return [rgba(*frame) for frame in moving(size, count)]
