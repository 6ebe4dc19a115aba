"""Mirrors: plane ones and balls, where they stand, how much they throw back, and where they make things seem to be."""

from __future__ import annotations

from collections.abc import Sequence

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray

from .pose import frozen_vector
from .view import View

Array = NDArray[np.float64]
MOST_MIRRORS = 8  # as in shaders/lib/mirrors.glsl


@attrs.frozen(eq=False)
class Mirror:
    """One mirror in the world, metres. A plane one is the rectangle centre +- right +- up, its front where right x up points.

    A curved one (radius_m above 0) is the ball around centre; right and up are 0 then. reflectivity: what it throws back when looked at
    straight on, 0 to 1; more at grazing angles, see `fresnel`.
    """

    centre_m: Array = attrs.field(converter=frozen_vector(3))
    right_m: Array = attrs.field(default=(0.0, 0.0, 0.0), converter=frozen_vector(3))
    up_m: Array = attrs.field(default=(0.0, 0.0, 0.0), converter=frozen_vector(3))
    radius_m: float = 0.0
    reflectivity: float = 1.0

    @property
    def is_curved(self) -> bool:
        """Whether it is a ball."""
        return self.radius_m > 0

    @property
    def normal(self) -> Array:
        """Unit normal of the front of a plane one."""
        across = np.cross(self.right_m, self.up_m)
        return across / np.linalg.norm(across)


def fresnel(reflectivity: ArrayLike, cosine: ArrayLike) -> Array:
    """Share of the light that is thrown back; cosine: of the angle between ray and normal, 0 to 1.

    Source: Schlick 1994, An Inexpensive BRDF Model for Physically-based Rendering, eq. 15.
    """
    reflectivity = np.asarray(reflectivity, np.float64)
    return reflectivity + (1 - reflectivity) * (1 - np.clip(cosine, 0, 1)) ** 5


def image_behind_ball(away_m: ArrayLike, radius_m: ArrayLike, cosine: ArrayLike) -> Array:
    """How far behind the surface of a ball, along the ray that looks at it, what it mirrors seems to be.

    away_m: from the surface to what is mirrored, along the mirrored ray, inf allowed. cosine: of the angle between ray and normal.
    1/v = 1/u + 2 / (R cos): half the radius for what is far and seen straight on, and 0, so glued on, at the rim. It is the focus in the
    plane of the two rays (the tangential one); across that plane things seem to be up to R / (2 cos) away, which no single depth can say.
    Source: Coddington 1829, A Treatise on the Reflexion and Refraction of Light (oblique pencils); Hecht 2017, Optics, 5.4.
    """
    cosine = np.maximum(np.asarray(cosine, np.float64), 1e-6)
    return 1 / (1 / np.asarray(away_m, np.float64) + 2 / (np.asarray(radius_m, np.float64) * cosine))


def mirrors_in_eye(mirrors: Sequence[Mirror], view: View) -> dict[str, object]:
    """The mirrors in the axes of an eye, as the uniforms of shaders/lib/mirrors.glsl. Errors: ValueError unless plane ones come first."""
    curved = [mirror.is_curved for mirror in mirrors]
    if len(mirrors) > MOST_MIRRORS or sorted(curved) != curved:
        raise ValueError(f"{len(mirrors)} mirrors, curved: {curved}; wanted at most {MOST_MIRRORS}, plane ones first")
    eye_from_world = view.pose.rotation.as_matrix().T
    shape, right, up = np.zeros((3, MOST_MIRRORS, 4))
    half, reflectivity = np.zeros((MOST_MIRRORS, 2)), np.zeros(MOST_MIRRORS)
    for i, mirror in enumerate(mirrors):
        centre = eye_from_world @ (mirror.centre_m - view.pose.position_m)
        reflectivity[i] = mirror.reflectivity
        if mirror.is_curved:
            shape[i] = *centre, mirror.radius_m
            continue
        half[i] = [np.linalg.norm(edge) for edge in (mirror.right_m, mirror.up_m)]
        axes = (mirror.normal, mirror.right_m / half[i, 0], mirror.up_m / half[i, 1])
        for row, axis in zip((shape, right, up), axes, strict=True):
            in_eye = eye_from_world @ axis
            row[i] = *in_eye, in_eye @ centre
    counts = {"plane_count": len(mirrors) - sum(curved), "mirror_count": len(mirrors)}
    rows = {"mirror_shape": shape, "mirror_right": right, "mirror_up": up, "mirror_half": half}
    return counts | rows | {"mirror_reflectivity": reflectivity}


def tangents_of_pixels(view: View, size: tuple[int, int]) -> dict[str, tuple[float, float]]:
    """The ray of pixel p is (tangent_start + p * tangent_step, -1)."""
    left, right, down, up = view.fov.tangents
    return {"tangent_start": (left, down), "tangent_step": ((right - left) / size[0], (up - down) / size[1])}
