"""Mirrors, plane and spherical: position and reflectivity."""

from __future__ import annotations

from collections.abc import Sequence

import attrs
import numpy as np
from numpy.typing import NDArray

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
    reflectivity: float = 1.0  # at normal incidence, 0 to 1; more at grazing angles (Schlick 1994)

    @property
    def is_curved(self) -> bool:
        """Whether it is a ball."""
        return self.radius_m > 0

    @property
    def normal(self) -> Array:
        """Unit normal of the front of a plane mirror."""
        across = np.cross(self.right_m, self.up_m)
        return across / np.linalg.norm(across)


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
