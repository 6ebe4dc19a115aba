"""A second view of an eye, much wider and coarser, for what comes into view when the head turns."""

from __future__ import annotations

import math

import attrs
import numpy as np

from .view import Fov, View

# Full angles. A plane's pixels grow with the square of the tangent: 160 degrees would double them,
# for ten degrees.
ACROSS, UPRIGHT = math.radians(150), math.radians(140)
# Times fewer pixels per tangent than the shown picture. Away from the axis a plane is sampled 1 /
# cos^2 times as densely as on it, four times at 60 degrees. So where the usual picture of 90 to 110
# degrees ends, a quarter of the density is half of what that picture has in its middle.
COARSER = 4


def wide_fov(fov: Fov) -> Fov:
    """Return 150 x 140 degrees around the eye's own field of view, or that where it is wider."""
    across, upright = math.tan(ACROSS / 2), math.tan(UPRIGHT / 2)
    left, right, down, up = fov.tangents
    return Fov.from_tangents((min(left, -across), max(right, across), min(down, -upright), max(up, upright)))


def wide_size(fov: Fov, size: tuple[int, int]) -> tuple[int, int]:
    """Return (w, h) of the wide view of an eye whose shown picture is (w, h) pixels of `fov`."""
    own, wide = fov.tangents, wide_fov(fov).tangents
    per_tangent = np.array(size) / (own[1::2] - own[::2]) / COARSER
    across, upright = np.ceil((wide[1::2] - wide[::2]) * per_tangent - 1e-6).astype(int).tolist()
    return max(1, across), max(1, upright)


def wide_view(view: View) -> View:
    """Return the same eye with the wide field of view."""
    return attrs.evolve(view, fov=wide_fov(view.fov))
