"""The floor the sun reaches: boards and rug with the window's light and the sharp shadows of everything on its way painted in."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ._paint import Image, rug
from ._pieces import INSIDE, Piece, surface_points
from ._room_shell import SUN_FLOOR, WINDOW

TEXEL_M = 0.003
RUG = (-0.75, -3.62, 1.75, -1.5)  # x0, z0, x1, z1
GAIN = 1.7  # how much brighter the sun makes a place than the room's own light


def sun_floor(boards: Image, pieces: Sequence[Piece], towards_sun: NDArray, rng: np.random.Generator) -> Image:
    """(h, w, 3) sRGB, to be drawn 1 + GAIN times as bright as baked; `boards` covers 2 m by 2 m."""
    x0, z0, x1, z1 = SUN_FLOOR
    width, height = round((x1 - x0) / TEXEL_M), round((z1 - z0) / TEXEL_M)
    x = (x0 + (np.arange(width, dtype=np.float32) + 0.5) * (x1 - x0) / width)[None]
    z = (z0 + (np.arange(height, dtype=np.float32) + 0.5) * (z1 - z0) / height)[:, None]
    image = _boards_at(boards, x, z)
    left, right = (round((e - x0) / TEXEL_M) for e in (RUG[0], RUG[2]))
    top, bottom = (round((e - z0) / TEXEL_M) for e in (RUG[1], RUG[3]))
    down, across = np.meshgrid(
        np.linspace(0, 1, bottom - top, dtype=np.float32),
        np.linspace(0, 1, right - left, dtype=np.float32),
        indexing="ij",
    )
    image[top:bottom, left:right] = (np.clip(rug(down, across), 0, 1) * 255).astype(np.uint8)
    sun = _window_light(x, z, towards_sun) * (1 - _shadow(pieces, (height, width), towards_sun, rng))
    return _dimmed(image, (1 + GAIN * sun) / (1 + GAIN))


def _boards_at(boards: Image, x: NDArray, z: NDArray) -> Image:
    size = len(boards)
    column = ((x / 2) % 1 * size).astype(int)
    row = ((z / 2) % 1 * size).astype(int)  # v runs along -z and the picture's rows run down, so rows run along +z
    return boards[row, column]


def _window_light(x: NDArray, z: NDArray, towards: NDArray) -> NDArray:
    t = (WINDOW.z_m - z) / towards[2]
    at_x, at_y = x + t * towards[0], t * towards[1] + 0 * x
    return ((at_x > WINDOW.left_m) & (at_x < WINDOW.right_m) & (at_y > WINDOW.bottom_m) & (at_y < WINDOW.top_m)).astype(
        np.float32
    )


def _shadow(pieces: Sequence[Piece], shape: tuple[int, int], towards: NDArray, rng: np.random.Generator) -> NDArray:
    """How much of the sun things take away, their points thrown to the floor; softened by what half a degree of sun blurs over 1.5 m."""
    from scipy.ndimage import gaussian_filter

    x0, z0, x1, z1 = SUN_FLOOR
    low, high = np.array([x0, 0.0, WINDOW.z_m - 0.3]), np.array([x1 + 1.6, 2.5, z1])
    full = np.zeros(shape, np.float32)
    for piece in pieces:
        box_low, box_high = piece.surface.positions.min(axis=0), piece.surface.positions.max(axis=0)
        if piece.place != INSIDE or not piece.shades or (box_low > high).any() or (box_high < low).any():
            continue
        points = surface_points(piece.surface, 0.006, rng)
        t = points[:, 1] / towards[1]
        column = ((points[:, 0] - t * towards[0] - x0) / (x1 - x0) * shape[1]).astype(int)
        row = ((points[:, 2] - t * towards[2] - z0) / (z1 - z0) * shape[0]).astype(int)
        kept = (column >= 0) & (column < shape[1]) & (row >= 0) & (row < shape[0])
        full[row[kept], column[kept]] = 1
    return np.clip(gaussian_filter(full, 2.0) * 2.6, 0, 1)


def _dimmed(image: Image, share: NDArray) -> Image:
    """sRGB bytes made `share` (h, w) times as bright in linear light; sRGB is nearly a power of 2.2 over the range that matters."""
    return (image * (share ** (1 / 2.2))[..., None] + 0.5).astype(np.uint8)
