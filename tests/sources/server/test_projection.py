"""Projection and culling in float64."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.sources.server import boxes_of, clip_from_eye, eye_from_scene
from hmdwarp.sources.server.visibility import NEAR_M, nearest_first, visible, world_from_ndc

angles = st.floats(0.05, 1.4)
fovs = st.builds(lambda a, b, c, d: Fov(-a, b, -c, d), angles, angles, angles, angles)
coordinate = st.floats(-50, 50)
vectors = st.tuples(coordinate, coordinate, coordinate)
poses = st.builds(Pose, vectors, st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: np.linalg.norm(q) > 0.1))


@given(fovs, st.tuples(st.floats(-3, 3), st.floats(-3, 3), st.floats(0.03, 1e4)))
def test_clip_space_lands_on_the_pixel_the_field_of_view_names(fov, point):
    x, y, depth = point
    clip = clip_from_eye(fov) @ (x * depth, y * depth, -depth, 1)
    pixel = (clip[:2] / clip[3] + 1) / 2 * (640, 400)
    expected = fov.pixel_from_tangent((640, 400)) @ (x, y, 1)
    # float64: a dozen operations on numbers of the size of the result's terms
    assert np.allclose(
        pixel, expected[:2], rtol=1e-12, atol=1e-12 * 640 * (1 + abs(x) + abs(y)) / np.ptp(fov.tangents[:2]).clip(max=1)
    )
    assert np.isclose(clip[3], depth)
    assert np.isclose((clip[2] / clip[3] + 1) / 2, 1 - NEAR_M / depth)


@given(poses, fovs, st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.just(1.0)), st.floats(0.03, 1e3), vectors)
def test_a_box_with_a_visible_point_in_it_is_never_culled(pose, fov, ndc, depth, half_size):
    view, half_size = View(pose, fov), np.abs(half_size)
    seen = pose.position_m + world_from_ndc(view) @ ndc * depth
    clip = clip_from_eye(fov) @ eye_from_scene(view, np.zeros(3))
    # 1e-6 m: a point on the very border may round to the outside
    assert visible(boxes_of((seen + half_size * 0.99)[None], half_size[None] + 1e-6 * (1 + depth)), clip).all()


def test_a_box_behind_the_eye_is_culled():
    clip = clip_from_eye(Fov.symmetric(1, 1)) @ eye_from_scene(View(Pose(), Fov.symmetric(1, 1)), np.zeros(3))
    assert visible(boxes_of(np.array([[0, 0, 5.0], [0, 0, -5.0], [9.0, 0, -5]]), np.ones((3, 3))), clip).tolist() == [
        False,
        True,
        False,
    ]


@given(st.lists(vectors, min_size=1, max_size=40), vectors, st.integers(1, 6))
def test_the_classes_are_those_of_numpys_quantiles(centres, eye, classes):
    centres, eye = np.array(centres), np.array(eye)
    farthest = np.linalg.norm(np.abs(centres - eye) + 1, axis=1)
    wanted = np.searchsorted(np.quantile(farthest, np.arange(1, classes) / classes), farthest, side="left")
    assert np.array_equal(nearest_first(boxes_of(centres, np.ones_like(centres)), eye, classes), wanted)
