"""The sunlit part of the room's floor: boards and rug with the window's light and sharp shadows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ._noise import Image
from ._surfaces import rug

FLOOR = (-2.7, -3.7, 1.9, -1.1)  # x0, z0, x1, z1 in metres
RUG = (-0.75, -3.62, 1.75, -1.5)
WINDOW_LEFT, WINDOW_RIGHT, WINDOW_BOTTOM, WINDOW_TOP, WINDOW_Z = -0.35, 2.25, 0.85, 2.35, -4.2
TEXEL_M = 0.003
ELEVATION, AZIMUTH = np.radians(36), np.radians(38)  # of the sun, azimuth from -z towards +x
TOWARDS_SUN = np.array([np.cos(ELEVATION) * np.sin(AZIMUTH), np.sin(ELEVATION), -np.cos(ELEVATION) * np.cos(AZIMUTH)])
GAIN = 1.7  # how much brighter the sun makes a place than the room's own light


def sun_floor(boards: Image, shaded: NDArray[np.bool_]) -> Image:
    """Return (h, w, 3) sRGB, to be drawn 1 + GAIN times as bright as baked.

    boards: 2 m by 2 m. shaded: (h, w), where things in the room intercept the sun.
    """
    from scipy.ndimage import gaussian_filter

    x0, z0, x1, z1 = FLOOR
    height, width = shaded.shape
    x = (x0 + (np.arange(width, dtype=np.float32) + 0.5) * (x1 - x0) / width)[None]
    z = (z0 + (np.arange(height, dtype=np.float32) + 0.5) * (z1 - z0) / height)[:, None]
    # Picture rows run down and v runs along -z, so rows run along +z.
    column, row = ((x / 2) % 1 * len(boards)).astype(int), ((z / 2) % 1 * len(boards)).astype(int)
    image = boards[row, column]
    left, right = (round((edge - x0) / TEXEL_M) for edge in RUG[::2])
    top, bottom = (round((edge - z0) / TEXEL_M) for edge in RUG[1::2])
    down, across = np.meshgrid(
        np.linspace(0, 1, bottom - top, dtype=np.float32),
        np.linspace(0, 1, right - left, dtype=np.float32),
        indexing="ij",
    )
    image[top:bottom, left:right] = (np.clip(rug(down, across), 0, 1) * 255).astype(np.uint8)
    # Half a degree of sun blurs a shadow by two texels over 1.5 m.
    shadow = np.clip(gaussian_filter(shaded.astype(np.float32), 2.0) * 2.6, 0, 1)
    share = (1 + GAIN * _window_light(x, z) * (1 - shadow)) / (1 + GAIN)
    # sRGB is nearly a power of 2.2 over the range that matters.
    return (image * (share ** (1 / 2.2))[..., None] + 0.5).astype(np.uint8)


def _window_light(x: NDArray, z: NDArray) -> NDArray[np.float32]:
    """Return 1 where the way to the sun goes through the window, else 0."""
    t = (WINDOW_Z - z) / TOWARDS_SUN[2]
    at_x, at_y = x + t * TOWARDS_SUN[0], t * TOWARDS_SUN[1] + 0 * x
    inside = (at_x > WINDOW_LEFT) & (at_x < WINDOW_RIGHT) & (at_y > WINDOW_BOTTOM) & (at_y < WINDOW_TOP)
    return inside.astype(np.float32)
