"""Pictures with alpha, (h, w, 4) uint8: glass with dust and lettering, a fence, a head-up display.

Colours continue where alpha is 0, so that no dark fringe appears where the sampler mixes both.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._noise import Field, Image, fractal, tinted, to_image, unit_grid
from ._prints import lettering


def with_alpha(colour: ArrayLike, alpha: NDArray) -> Image:
    """Return one sRGB colour, or a (h, w, 3) picture, with (h, w) alpha, all of 0..1."""
    height, width = alpha.shape
    picture = np.broadcast_to(np.asarray(colour, np.float32), (height, width, 3))
    return to_image(np.concatenate([picture, np.clip(alpha, 0, 1)[..., None]], axis=2))


def dusty_glass(words: tuple[str, ...], size: int = 512, seed: int = 800) -> Image:
    """Paint a pane with rain-streaked dust, dirt in its corners and lettering."""
    y, x = np.meshgrid(np.linspace(0, 1, size), np.linspace(0, 1, size), indexing="ij")
    film = 0.10 + 0.035 * fractal(size, size, seed, 1.3) + 0.03 * fractal(size, size, seed + 1, 0.6, (0.12, 1.0))
    specks = np.clip(fractal(size, size, seed + 2, 0.55) - 2.3, 0, 1) * 0.5
    from_edge = np.minimum(np.minimum(x, 1 - x), np.minimum(y, 1 - y))
    mud = np.clip(5 * (y - 0.82), 0, 1) * np.clip(0.6 + 0.4 * fractal(size, size, seed + 3, 1.1), 0, 1)
    rim = 0.35 * np.exp(-from_edge / 0.02) + 0.22 * mud
    alpha = np.clip(film, 0.04, 1) + specks + rim
    colour = np.broadcast_to(np.array((0.80, 0.79, 0.72), np.float32), (size, size, 3)).copy()
    scale = round(0.8 * size / (6 * max(map(len, words), default=1)))
    for line, word in enumerate(words):
        mask = lettering(word, scale)
        top, left = round(size * 0.24) + 9 * scale * line, (size - mask.shape[1]) // 2
        area = np.s_[top : top + mask.shape[0], left : left + mask.shape[1]]
        alpha[area] = np.where(mask, 0.92, alpha[area])
        colour[area] = np.where(mask[..., None], (0.93, 0.90, 0.78), colour[area])
    return with_alpha(colour, alpha)


def leaded_glass(size: int = 256, seed: int = 820) -> Image:
    """Paint a thin film of dust over diamonds of lead."""
    y, x = unit_grid(size, size)
    lead = np.minimum(_to_line((x + y) * 3), _to_line((x - y) * 3)) < 0.035
    film = np.clip(0.12 + 0.03 * fractal(size, size, seed, 1.0), 0.05, 0.4)
    return with_alpha(np.where(lead[..., None], (0.16, 0.16, 0.17), (0.85, 0.85, 0.8)), np.where(lead, 1.0, film))


def _to_line(value: Field) -> Field:
    """Return the distance to the nearest integer."""
    return np.abs(value - np.round(value))


def pickets(size: int = 256, seed: int = 840) -> Image:
    """Paint two pointed laths and two rails behind them, with air between."""
    y, x = np.meshgrid(np.linspace(1, 0, size), np.arange(size) / size * 2, indexing="ij")
    across = np.abs(x % 1 - 0.5)
    lath = (across < 0.27) & (y < 0.98 - 0.42 * across)
    rail = (np.abs(y - 0.26) < 0.055) | (np.abs(y - 0.72) < 0.055)
    grain = 0.6 + 0.14 * fractal(size, size, seed, 0.9, (0.15, 1.0)) + 0.05 * fractal(size, size, seed + 1, 0.2)
    colour = tinted(grain * np.where(lath, 1.0, 0.7), (0.34, 0.24, 0.16), (0.90, 0.84, 0.72))
    return with_alpha(colour, (lath | rail).astype(np.float32))


def head_up(size: int = 768) -> Image:
    """Paint a head-up display: crosshair, pitch ladder, heading marks and readings."""
    y, x = np.meshgrid(np.linspace(1, -1, size), np.linspace(-1, 1, size), indexing="ij")
    far, line = np.hypot(x, y), 2.4 / size
    lit = (np.abs(far - 0.16) < line) | ((np.minimum(np.abs(x), np.abs(y)) < line) & (far > 0.05) & (far < 0.12))
    for step in (-3, -2, -1, 1, 2, 3):
        bar = (np.abs(y - 0.17 * step) < line) & (np.abs(x) > 0.2) & (np.abs(x) < 0.42 - 0.03 * abs(step))
        lit |= bar & ((step > 0) | ((x * 24).astype(int) % 2 == 0))
    lit |= (
        (np.abs(_to_line(x * 10)) < line * 8)
        & (np.abs(x) < 0.72)
        & (y > 0.78)
        & (y < np.where(_to_line(x * 5) < 0.05, 0.86, 0.82))
    )
    lit |= (np.abs(y - 0.78) < line) & (np.abs(x) < 0.72)
    for side in (-1, 1):
        lit |= (np.abs(x - side * 0.66) < line) & (np.abs(y) < 0.5)
        lit |= (np.abs(_to_line(y * 12)) < line * 10) & (side * x > 0.66) & (side * x < 0.71) & (np.abs(y) < 0.5)
    lit = lit.astype(np.float32)
    places = {
        "080": (0.055, 0.455),
        "LATENCY": (0.90, 0.08),
        "1240": (0.45, 0.86),
        "148": (0.45, 0.05),
        "HOLD": (0.9, 0.8),
    }
    for text, (down, across) in places.items():
        mask = lettering(text, 3)
        top, left = round(down * size), round(across * size)
        area = lit[top : top + mask.shape[0], left : left + mask.shape[1]]
        area[mask[: area.shape[0], : area.shape[1]]] = 1
    glow = np.clip(
        0.06 - 0.05 * np.maximum(np.abs(x), np.abs(y)) ** 4, 0, 1
    )  # the glass itself, so that its border shows
    return with_alpha((0.42, 1.0, 0.55), np.maximum(0.95 * lit, glow * (np.maximum(np.abs(x), np.abs(y)) < 0.97)))
