"""Twin of the lens pass: NumPy's polynomial in polar form and SciPy's interpolation."""

from __future__ import annotations

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage

from hmdwarp.geometry import Fov
from hmdwarp.headsets import Headset, RadialLens
from reference._rays import Array


def tangent_from_lens(lens: RadialLens, on_lens: ArrayLike, colour: str) -> NDArray[np.float64]:
    """Return the tangents that the lens shows at positions (..., 2) on the lens plane."""
    on_lens = np.asarray(on_lens, dtype=np.float64)
    r2 = (on_lens**2).sum(axis=-1, keepdims=True)
    return on_lens * lens.tangent_per_unit * polynomial.polyval(r2, np.array(lens.coefficients[colour]))


def radial(shown: Array, fov: Fov, headset: Headset, eye: int, panel_size: tuple[int, int]) -> Array:
    """(h, w, 4) shown picture, bottom row first, to the (h, w, 4) panel picture. Black where the
    lens shows more than was rendered."""
    high, wide = shown.shape[:2]
    scale, offset = headset.lens_from_panel(eye, panel_size)
    x, y = (np.arange(n) + 0.5 for n in panel_size)
    on_lens = np.stack(np.meshgrid(x * scale[0] + offset[0], y * scale[1] + offset[1]), axis=-1)
    radius, angle = np.hypot(on_lens[..., 0], on_lens[..., 1]), np.arctan2(on_lens[..., 1], on_lens[..., 0])
    left, right, down, up = fov.tangents
    out = np.zeros((panel_size[1], panel_size[0], 4))
    for channel, colour in enumerate(("red", "green", "blue")):
        along = tangent_from_lens(headset.lens, np.stack([radius, np.zeros_like(radius)], axis=-1), colour)[..., 0]
        u = (along * np.cos(angle) - left) / (right - left)
        v = (along * np.sin(angle) - down) / (up - down)
        seen = (u >= 0) & (u <= 1) & (v >= 0) & (v <= 1)
        coords = [v * high - 0.5, u * wide - 0.5]
        for target in (channel, 3) if colour == "green" else (channel,):
            looked = ndimage.map_coordinates(shown[..., target], coords, order=1, mode="nearest")
            out[..., target] = np.where(seen, looked, 0)
    return out
