"""Pictures around the eye: everything in a cube, and a wide view in one picture."""

from __future__ import annotations

import math
from typing import NamedTuple

import attrs
import numpy as np

from .pose import Pose
from .view import Fov, View

_Q = math.sqrt(0.5)  # of a quarter turn


class _Face(NamedTuple):
    name: str
    column: int  # where it lies in the picture
    row: int  # 0 is the bottom row
    eye_from_face: tuple[float, float, float, float]  # how it is turned against the eye, quaternion xyzw


FACES = (
    _Face("left", 0, 0, (0.0, _Q, 0.0, _Q)),
    _Face("front", 1, 0, (0.0, 0.0, 0.0, 1.0)),
    _Face("right", 2, 0, (0.0, -_Q, 0.0, _Q)),
    _Face("down", 0, 1, (-_Q, 0.0, 0.0, _Q)),
    _Face("back", 1, 1, (0.0, 1.0, 0.0, 0.0)),
    _Face("up", 2, 1, (_Q, 0.0, 0.0, _Q)),
)


def cube_size(fov: Fov, size: tuple[int, int]) -> tuple[int, int]:
    """Return (w, h) of the six faces around an eye whose picture is (w, h) pixels of `fov`.

    They are as dense, so that looking along one loses no detail, and have borders of a pixel.
    """
    left, right, down, up = fov.tangents
    side = int(max(1, math.ceil(2 * max(size[0] / (right - left), size[1] / (up - down)) - 1e-6))) + 2
    return 3 * side, 2 * side


def face_views(view: View, side: int) -> tuple[View, ...]:
    """Return the views of FACES, borders included, around an eye. side: at least 3 pixels."""
    edge = side / (side - 2)
    fov = Fov.from_tangents((-edge, edge, -edge, edge))
    return tuple(View(view.pose @ Pose(orientation_xyzw=face.eye_from_face), fov) for face in FACES)


# Full angles. 160 degrees would double a plane's pixels, for ten degrees.
ACROSS, UPRIGHT = math.radians(150), math.radians(140)
# Times fewer pixels per tangent than the shown picture: a plane is sampled 1 / cos^2 times as
# densely away from its axis, so that at 45 to 55 degrees half of the picture's middle is left.
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
