"""What is drawn for a view: never too little, the same whatever was drawn before, hardly more."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.sources.server import Visibility, boxes_of, clip_from_eye, draws_of, eye_from_scene
from hmdwarp.sources.server.passes import KEPT, NEAR_M, Chunks, visible, world_from_ndc

angles = st.floats(0.05, 1.4)
fovs = st.builds(lambda a, b, c, d: Fov(-a, b, -c, d), angles, angles, angles, angles)
turns = st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: np.linalg.norm(q) > 0.1)
near, vectors = (st.tuples(*[st.floats(-most, most)] * 3) for most in (5, 50))
sizes = st.tuples(*[st.floats(0.01, 3)] * 3)
boxes = st.lists(st.tuples(st.tuples(*[st.floats(-20, 20)] * 3), sizes), min_size=1, max_size=30)


@given(fovs, st.tuples(st.floats(-3, 3), st.floats(-3, 3), st.floats(0.03, 1e4)))
def test_clip_space_lands_on_the_pixel_the_field_of_view_names(fov, point):
    x, y, depth = point
    clip = clip_from_eye(fov) @ (x * depth, y * depth, -depth, 1)
    pixel = (clip[:2] / clip[3] + 1) / 2 * (640, 400)
    expected = fov.pixel_from_tangent((640, 400)) @ (x, y, 1)
    # float64: a dozen operations on numbers of the size of the result's terms
    within = 1e-12 * 640 * (1 + abs(x) + abs(y)) / np.ptp(fov.tangents[:2]).clip(max=1)
    assert np.allclose(pixel, expected[:2], rtol=1e-12, atol=within)
    assert np.isclose(clip[3], depth)
    assert np.isclose((clip[2] / clip[3] + 1) / 2, 1 - NEAR_M / depth)


@given(vectors, turns, fovs, st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.just(1.0)), st.floats(0.03, 1e3), vectors)
def test_a_box_with_a_visible_point_in_it_is_never_culled(place, turn, fov, ndc, depth, half_size):
    pose, half_size = Pose(place, turn), np.abs(half_size)
    view = View(pose, fov)
    seen = pose.position_m + world_from_ndc(view) @ ndc * depth
    clip = clip_from_eye(fov) @ eye_from_scene(view, np.zeros(3))
    # 1e-6 m: a point on the very border may round to the outside
    assert visible(boxes_of((seen + half_size * 0.99)[None], half_size[None] + 1e-6 * (1 + depth)), clip).all()


def chunks_of(centres, half_sizes) -> Chunks:
    """Chunks of three indices each, in two batches, none of them neighbours."""
    n = len(centres)
    places = boxes_of(np.array(centres, float), np.array(half_sizes, float))
    return Chunks(np.arange(n) * 10, np.full(n, 3), np.arange(n) % 2, places)


@given(boxes, near, turns, fovs)
def test_all_that_a_view_sees_is_drawn(boxes, position, turn, fov):
    """And for a quaternion and its negative, one turn, the same."""
    chunks, view = chunks_of(*zip(*boxes, strict=True)), View(Pose(position, turn), fov)
    exact = visible(chunks.boxes, clip_from_eye(fov) @ eye_from_scene(view, np.zeros(3)))
    sights, there, eye = Visibility(chunks), view.pose.unit_quaternion, view.pose.position_m
    drawn = sights.near(there, eye, fov)
    found = {first // 10 for _, spans in drawn for first, _ in spans}
    assert set(exact.nonzero()[0].tolist()) <= found
    if abs(there[3]) > 1e-6:  # at a half turn the two may lie in two cells, which may hold a little more each
        assert sights.near(tuple(-q for q in there), eye, fov) is drawn


def test_the_order_does_not_depend_on_what_was_drawn_before():
    rng = np.random.default_rng(4)
    chunks, fov = chunks_of(rng.uniform(-9, 9, (200, 3)), rng.uniform(0.1, 1, (200, 3))), Fov.symmetric(1.6, 1.5)
    views = [(Pose((0, 0, 0), rng.normal(size=4)).unit_quaternion, rng.uniform(-3, 3, 3)) for _ in range(3 * KEPT)]
    kept = Visibility(chunks)
    there = [kept.near(turn, eye, fov) for turn, eye in views]
    back = [kept.near(turn, eye, fov) for turn, eye in reversed(views)]
    assert there == back[::-1]
    assert kept._draws.cache_info().currsize == KEPT


def test_every_chunk_is_drawn_once_and_neighbours_in_one_call():
    first = np.array([0, 3, 6, 20])
    chunks = Chunks(first, np.full(4, 3), np.array([0, 0, 0, 1]), boxes_of(np.zeros((4, 3)), np.ones((4, 3))))
    assert draws_of(chunks, np.ones(4, bool), np.zeros(3)) == ((0, ((0, 9),)), (1, ((20, 3),)))
    assert draws_of(chunks, np.zeros(4, bool), np.zeros(3)) == ()


def test_little_more_is_drawn_than_is_seen(serve):
    """Of the room, over a look around: its triangles are what drawing costs on a processor."""
    server = serve("room")
    chunks, visibility, fov = server._buffers.chunks, server._buffers.visibility, Fov.symmetric(1.57, 1.75)
    seen = cell = 0
    for turn in np.radians(range(0, 360, 2)):
        view = View(Pose((0.3 * math.sin(turn), 1.6, 0.2), (0, math.sin(turn / 2), 0, math.cos(turn / 2))), fov)
        exact = visible(chunks.boxes, clip_from_eye(fov) @ eye_from_scene(view, server.scene.origin_m))
        draws = visibility.near(view.pose.unit_quaternion, view.pose.position_m - server.scene.origin_m, fov)
        seen += chunks.count[exact].sum()
        cell += sum(count for _, spans in draws for _, count in spans)
    assert seen <= cell <= 1.25 * seen
