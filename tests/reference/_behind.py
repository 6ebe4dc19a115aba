"""What fills take for farther and for one surface: the float64 side of shaders/lib/behind.glsl."""

from __future__ import annotations

import attrs
import numpy as np

from reference._rays import Array


@attrs.frozen
class Behind:
    """Inverse depths in 1/m; one that is not known is np.inf, nearer than all others.

    tolerance, floor: as the fills' settings.
    """

    tolerance: float
    floor: float

    def limit(self, farthest: Array) -> Array:
        """Up to where something is of the same surface as what is `farthest`."""
        return farthest + self.tolerance * (farthest + self.floor)

    def share(self, depth: Array, farthest: Array) -> Array:
        """1 for what is as far as `farthest` or farther.

        Nearer, with x tolerances between them, 1 / (1 + x^4), and 0 beyond x = 100.
        """
        with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
            x = np.maximum(depth - farthest, 0) / (self.tolerance * (farthest + self.floor) + 1e-12)
            x = np.where(depth == farthest, 0.0, x)  # both unknown
            x = np.where(np.isinf(farthest), 0.0, x)
            return np.where(x < 100, 1 / (1 + x**4), 0.0)


def known_or_infinite(inverse_depth: Array) -> Array:
    """-1, not known, to np.inf."""
    return np.where(inverse_depth >= 0, inverse_depth, np.inf)


def as_stored(depth: Array) -> Array:
    """And back."""
    return np.where(np.isfinite(depth), depth, -1.0)
