"""Six square views around an eye, laid side by side in one picture: a cube map without seams.

The faces turn with their eye. One face is n x n pixels: an inner square of (n - 2) x (n - 2) that
spans exactly 90 degrees, and a border of one pixel, so that a bilinear look anywhere in the inner
square stays within the face. The picture is 3n wide and 2n high, row 0 at the bottom:

    row 1:  down  (-y)   back   (+z)   up     (+y)
    row 0:  left  (-x)   front  (-z)   right  (+x)

Source: Greene 1986, Environment Mapping and Other Applications of World Projections; OpenGL 4.3
specification, 8.13 (seams).
"""

from __future__ import annotations

import math

import attrs

from .pose import Pose
from .view import Fov, View

_Q = math.sqrt(0.5)  # of a quarter turn


@attrs.frozen
class Face:
    """One face of the cube."""

    name: str
    column: int  # where it lies in the picture
    row: int  # 0 is the bottom row
    # how it is turned against the eye, quaternion xyzw
    eye_from_face: tuple[float, float, float, float]


FACES = (
    Face("left", 0, 0, (0.0, _Q, 0.0, _Q)),
    Face("front", 1, 0, (0.0, 0.0, 0.0, 1.0)),
    Face("right", 2, 0, (0.0, -_Q, 0.0, _Q)),
    Face("down", 0, 1, (-_Q, 0.0, 0.0, _Q)),
    Face("back", 1, 1, (0.0, 1.0, 0.0, 0.0)),
    Face("up", 2, 1, (_Q, 0.0, 0.0, _Q)),
)


def inner_size(fov: Fov, size: tuple[int, int]) -> int:
    """Return how many pixels span 90 degrees of a face as dense as the (w, h) picture of `fov`.

    Density counts in pixels per tangent: looking along a face, no detail of the picture is lost.
    """
    left, right, down, up = fov.tangents
    return max(1, math.ceil(2 * max(size[0] / (right - left), size[1] / (up - down)) - 1e-6))


def cube_size(fov: Fov, size: tuple[int, int]) -> tuple[int, int]:
    """Return (w, h) of the six faces around an eye whose picture is (w, h) pixels of `fov`."""
    side = inner_size(fov, size) + 2
    return 3 * side, 2 * side


def face_views(view: View, side: int) -> tuple[View, ...]:
    """Return the views of FACES, borders included, around the eye of `view`.

    side: n, at least 3 pixels.
    """
    edge = side / (side - 2)
    fov = Fov.from_tangents((-edge, edge, -edge, edge))
    return tuple(View(view.pose @ Pose(orientation_xyzw=face.eye_from_face), fov) for face in FACES)
