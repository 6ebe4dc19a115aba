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


def lens_from_tangent(lens: RadialLens, tangent: ArrayLike, colour: str) -> NDArray[np.float64]:
    """Return the positions on the lens plane that show tangents (..., 2); NaN beyond reach. Bisects
    the radius: 60 halvings of 0..reach leave less than one unit in the last place of reach."""
    tangent = np.asarray(tangent, dtype=np.float64)
    wanted = np.sqrt((tangent**2).sum(axis=-1)) / lens.tangent_per_unit
    k = np.array(lens.coefficients[colour])

    def radius_function(r: NDArray[np.float64]) -> NDArray[np.float64]:
        return r * polynomial.polyval(r * r, k)

    low, high = np.zeros_like(wanted), np.full_like(wanted, lens.reach)
    for _ in range(60):
        middle = (low + high) / 2
        below = radius_function(middle) < wanted
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    r = (low + high) / 2
    seen = wanted <= radius_function(np.array(lens.reach)) * (1 + 1e-12)
    scale = np.divide(r, wanted, out=np.full_like(r, 1 / k[0]), where=wanted > 0)
    return np.where(seen[..., None], tangent / lens.tangent_per_unit * scale[..., None], np.nan)


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
