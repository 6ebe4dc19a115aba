"""Where a ball's image stands, as shaders/lib/mirrors.glsl."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def image_behind_ball(away_m: ArrayLike, radius_m: ArrayLike, cosine: ArrayLike) -> Array:
    """Return how far behind a ball's surface, along the viewing ray, the mirrored point appears.

    away_m: from the surface to the mirrored point, along the mirrored ray; inf allowed.
    cosine: of the angle between ray and normal.

    1/v = 1/u + 2 / (R cos): half the radius for distant points seen straight on, and 0 at the rim.
    This is the tangential focus, in the plane of the two rays; across that plane points appear up
    to R / (2 cos) away, which no single depth can express.

    Source: Coddington 1829, A Treatise on the Reflexion and Refraction of Light (oblique pencils);
    Hecht 2017, Optics, 5.4.
    """
    cosine = np.maximum(np.asarray(cosine, np.float64), 1e-6)
    return 1 / (1 / np.asarray(away_m, np.float64) + 2 / (np.asarray(radius_m, np.float64) * cosine))
