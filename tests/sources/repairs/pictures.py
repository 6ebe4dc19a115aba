"""Pictures with depth that has known faults."""

from __future__ import annotations

import numpy as np


def two_surfaces(size=(96, 72), near=1.0, far=0.25, rng=None) -> tuple[np.ndarray, np.ndarray]:
    """A disc before a wall, each of one colour with some noise: sRGB colour, inverse depth."""
    rng = np.random.default_rng(0) if rng is None else rng
    wide, high = size
    rows, columns = np.indices((high, wide))
    disc = (rows - 0.45 * high) ** 2 + (columns - 0.55 * wide) ** 2 < (0.3 * high) ** 2
    colour = np.where(disc[..., None], (0.8, 0.3, 0.2), (0.2, 0.4, 0.6)) + 0.02 * rng.standard_normal((high, wide, 3))
    return np.clip(colour, 0, 1).astype(np.float32), np.where(disc, near, far).astype(np.float32)


def moved(values: np.ndarray, down: int, right: int) -> np.ndarray:
    """The picture moved by whole pixels, NaN where nothing comes in."""
    padded = np.pad(values, 16, constant_values=np.nan)
    high, wide = values.shape
    return padded[16 - down : 16 - down + high, 16 - right : 16 - right + wide]


def same(one: np.ndarray, other: np.ndarray) -> bool:
    """Bit for bit, NaN included."""
    return one.dtype == other.dtype and np.array_equal(one, other, equal_nan=True)
