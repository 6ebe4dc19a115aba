"""How much a mirror throws back, and where a ball's image stands, as shaders/lib/mirrors.glsl."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def fresnel(reflectivity: ArrayLike, cosine: ArrayLike) -> Array:
    """Return the reflected share of the light.

    cosine: of the angle between ray and normal, 0 to 1.
    Source: Schlick 1994, An Inexpensive BRDF Model for Physically-based Rendering, eq. 15.
    """
    reflectivity = np.asarray(reflectivity, np.float64)
    return reflectivity + (1 - reflectivity) * (1 - np.clip(cosine, 0, 1)) ** 5


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


def image_by_two_rays(away_m: float, radius_m: float, incidence_rad: float, step: float = 1e-5) -> float:
    """How far behind a ball's surface the image of a point stands, seen at two places of the ball
    `step` radians apart.

    In the plane of the two rays: from a point `away_m` from the surface along the mirrored ray,
    light goes to either place and is thrown back there; where the two lines of sight meet behind
    the surface is the image.
    """

    def normal_at(angle: float) -> Array:
        return np.array([np.sin(angle), np.cos(angle)])

    def turned(vector: Array, angle: float) -> Array:
        c, s = np.cos(angle), np.sin(angle)
        return np.array([c * vector[0] + s * vector[1], -s * vector[0] + c * vector[1]])  # clockwise, as normal_at

    first = radius_m * normal_at(0.0)
    mirrored, incoming = (
        turned(normal_at(0.0), incidence_rad),
        turned(normal_at(0.0), -incidence_rad),
    )  # both away from the surface
    point = first + away_m * mirrored
    second = radius_m * normal_at(step)
    towards_point = (point - second) / np.linalg.norm(point - second)
    normal = normal_at(step)
    towards_eye = 2 * (towards_point @ normal) * normal - towards_point
    # first - a * incoming = second - b * towards_eye
    along = np.linalg.solve(np.stack([incoming, -towards_eye], axis=1), first - second)
    return float(along[0])
