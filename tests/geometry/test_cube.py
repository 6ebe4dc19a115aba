"""The cube around an eye.

Faces that meet without a gap, every direction in one of them, sizes as sharp as the picture.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import FOVS, poses

from hmdwarp.geometry import Fov, Pose, View, cube_size, face_views
from hmdwarp.geometry.cube import FACES, inner_size

AHEAD = {
    "left": (-1, 0, 0), "right": (1, 0, 0), "down": (0, -1, 0), "up": (0, 1, 0), "front": (0, 0, -1), "back": (0, 0, 1),
}  # fmt: skip


def test_faces_look_where_their_names_say():
    for face, view in zip(FACES, face_views(View(Pose(), Fov.symmetric(1, 1)), 10), strict=True):
        assert view.pose.transform((0, 0, -1)) == pytest.approx(AHEAD[face.name], abs=1e-15)
    assert len({(face.column, face.row) for face in FACES}) == 6


@given(poses(), st.integers(3, 2000), st.integers(0, 2**32 - 1))
@settings(max_examples=50)
def test_every_direction_lies_in_one_inner_square(pose, side, seed):
    """Of the six faces one holds it within 90 degrees.

    Two only where its largest coordinates are equal.
    """
    directions = np.random.default_rng(seed).normal(size=(50, 3))
    holds = 0
    for view in face_views(View(pose, Fov.symmetric(1, 1)), side):
        x, y, z = (directions @ view.pose.rotation.as_matrix()).T
        holds = holds + ((z < 0) & (np.abs(x) <= -z) & (np.abs(y) <= -z))
    assert (holds == 1).all()


@pytest.mark.parametrize("side", [3, 4, 17, 600])
def test_inside_a_border_of_one_pixel_a_face_spans_ninety_degrees(side):
    fov = face_views(View(Pose(), Fov.symmetric(1, 1)), side)[0].fov
    to_pixel = fov.pixel_from_tangent((side, side))
    assert to_pixel @ (-1, -1, 1) == pytest.approx((1, 1, 1))
    assert to_pixel @ (1, 1, 1) == pytest.approx((side - 1, side - 1, 1))


@given(FOVS, st.tuples(st.integers(1, 3000), st.integers(1, 3000)))
def test_a_face_is_at_least_as_dense_as_the_picture_and_no_denser_than_needed(fov, size):
    left, right, down, up = fov.tangents
    densest = max(size[0] / (right - left), size[1] / (up - down))
    inner = inner_size(fov, size)
    assert inner >= 2 * densest * (1 - 1e-6) - 1e-6
    assert inner <= max(1, 2 * densest + 1)
    assert cube_size(fov, size) == (3 * (inner + 2), 2 * (inner + 2))


def test_a_picture_of_ninety_degrees_has_faces_of_its_own_size():
    """Whatever the last bits of the tangents say."""
    assert inner_size(Fov.symmetric(np.pi / 2, np.pi / 2), (512, 512)) == 512
