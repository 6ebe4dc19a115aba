"""The radial lens and its inverse, in float64: what shaders and maps are compared with."""

from __future__ import annotations

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import ArrayLike, NDArray

from hmdwarp.headsets import RadialLens


def tangent_from_lens(lens: RadialLens, on_lens: ArrayLike, colour: str) -> NDArray[np.float64]:
    """Return the tangents that the lens shows at positions (..., 2) on the lens plane."""
    on_lens = np.asarray(on_lens, dtype=np.float64)
    r2 = (on_lens**2).sum(axis=-1, keepdims=True)
    return on_lens * lens.tangent_per_unit * polynomial.polyval(r2, np.array(lens.coefficients[colour]))


def lens_from_tangent(lens: RadialLens, tangent: ArrayLike, colour: str) -> NDArray[np.float64]:
    """Return the positions on the lens plane that show tangents (..., 2); NaN beyond reach.

    Bisects the radius: 60 halvings of 0..reach leave less than one unit in the last place of reach.
    """
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
