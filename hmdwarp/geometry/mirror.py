"""Mirrors, plane and spherical: position, reflectivity, and where their images appear."""

from __future__ import annotations

from collections.abc import Sequence

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray

from .pose import frozen3
from .view import View

Array = NDArray[np.float64]
MOST_MIRRORS = 8  # as in shaders/lib/mirrors.glsl


@attrs.frozen(eq=False)
class Mirror:
    """One mirror in the world, in metres.

    A plane mirror is the rectangle centre +- right +- up; its front faces right x up. A curved one
    (radius_m > 0) is the ball around centre; right and up are then 0.
    """

    centre_m: Array = attrs.field(converter=frozen3)
    right_m: Array = attrs.field(default=(0.0, 0.0, 0.0), converter=frozen3)
    up_m: Array = attrs.field(default=(0.0, 0.0, 0.0), converter=frozen3)
    radius_m: float = 0.0
    reflectivity: float = 1.0  # at normal incidence, 0 to 1; more at grazing angles, see `fresnel`

    @property
    def is_curved(self) -> bool:
        """Whether it is a ball."""
        return self.radius_m > 0

    @property
    def normal(self) -> Array:
        """Unit normal of the front of a plane mirror."""
        across = np.cross(self.right_m, self.up_m)
        return across / np.linalg.norm(across)


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


def mirrors_in_eye(mirrors: Sequence[Mirror], view: View) -> dict[str, object]:
    """Return the mirrors in the axes of an eye, as the uniforms of shaders/lib/mirrors.glsl."""
    if len(mirrors) > MOST_MIRRORS:
        raise ValueError(f"{len(mirrors)} mirrors: expected at most {MOST_MIRRORS}")
    eye_from_world = view.pose.rotation_matrix.T
    rows = np.zeros((3, MOST_MIRRORS, 4))
    reflectivity = np.zeros(MOST_MIRRORS)
    for i, mirror in enumerate(mirrors):
        rows[0, i] = *(eye_from_world @ (mirror.centre_m - view.pose.position_m)), mirror.radius_m
        for row, half in ((1, mirror.right_m), (2, mirror.up_m)):
            length = float(np.linalg.norm(half))
            rows[row, i] = *(eye_from_world @ half / max(length, 1e-30)), length
        reflectivity[i] = mirror.reflectivity
    named = dict(zip(("mirror_centre", "mirror_right", "mirror_up"), rows, strict=True))
    return {"mirror_count": len(mirrors), "mirror_reflectivity": reflectivity, **named}


def tangents_of_pixels(view: View, size: tuple[int, int]) -> dict[str, tuple[float, float]]:
    """Return uniforms of pixel rays.

    The ray of pixel p is (tangent_start + p * tangent_step, -1).
    """
    left, right, down, up = view.fov.tangents
    return {"tangent_start": (left, down), "tangent_step": ((right - left) / size[0], (up - down) / size[1])}
