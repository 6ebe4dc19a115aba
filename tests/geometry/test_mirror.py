"""Mirrors in an eye's axes, and the cube around an eye."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import FOVS, poses

from hmdwarp.geometry import Fov, Mirror, Pose, View, cube_size, face_views
from hmdwarp.geometry.cube import FACES
from hmdwarp.geometry.view import MOST_MIRRORS, mirrors_in_eye, tangents_of_pixels


def test_mirrors_in_an_eye_keep_their_shape_far_from_the_origin():
    far = np.array([1e6, -1e6, 1e6])
    turn = (0.1, -0.4, 0.2, 0.8)
    mirrors = [Mirror((0.5, 1, -2), (0.3, 0, 0.1), (0, 0.7, 0), reflectivity=0.4), Mirror((0, 1, -1), radius_m=0.2)]
    moved = [Mirror(m.centre_m + far, m.right_m, m.up_m, m.radius_m, m.reflectivity) for m in mirrors]
    fov = Fov(-0.5, 0.6, -0.7, 0.4)
    here = mirrors_in_eye(mirrors, View(Pose((0.1, 1.5, 0.2), turn), fov))
    there = mirrors_in_eye(moved, View(Pose(far + (0.1, 1.5, 0.2), turn), fov))
    assert here["mirror_count"] == there["mirror_count"] == 2
    for name in ("mirror_centre", "mirror_right", "mirror_up", "mirror_reflectivity"):
        assert np.abs(here[name] - there[name]).max() < 1e-9, name  # 1e6 m have steps of 1e-10 m
    assert np.linalg.norm(here["mirror_right"][0, :3]) == pytest.approx(1)
    assert here["mirror_right"][0, 3] == pytest.approx(np.hypot(0.3, 0.1))
    assert here["mirror_centre"][1, 3] == 0.2


def test_too_many_mirrors_are_refused():
    with pytest.raises(ValueError, match="9 mirrors"):
        mirrors_in_eye([Mirror((0, 0, 0), radius_m=1.0)] * (MOST_MIRRORS + 1), View(Pose(), Fov(-1, 1, -1, 1)))


def test_pixels_run_over_the_tangents():
    view = View(Pose(), Fov(-0.5, 0.6, -0.7, 0.4))
    found = tangents_of_pixels(view, (97, 61))
    rays = view.rays((97, 61))
    expected = np.array(found["tangent_start"]) + (np.array([3, 7]) + 0.5) * found["tangent_step"]
    assert np.abs(rays[7, 3, :2] - expected).max() < 1e-12


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
    """Of the six faces one holds it within 90 degrees. Two only where its largest coordinates are
    equal."""
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
    (wide, high), inner = cube_size(fov, size), cube_size(fov, size)[0] // 3 - 2
    assert inner >= 2 * densest * (1 - 1e-6) - 1e-6
    assert inner <= max(1, 2 * densest + 1) and 2 * wide == 3 * high
