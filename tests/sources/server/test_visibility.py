"""What is drawn for a view.

Never too little, the same for the same view whatever was drawn before, and little more than is
seen.
"""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.sources.server import Visibility, boxes_of, clip_from_eye, draws_of, eye_from_scene
from hmdwarp.sources.server.visibility import KEPT, Chunks, visible

angles = st.floats(0.05, 1.4)
fovs = st.builds(lambda a, b, c, d: Fov(-a, b, -c, d), angles, angles, angles, angles)
near = st.tuples(*[st.floats(-5, 5)] * 3)
turns = st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: np.linalg.norm(q) > 0.1)


def chunks_of(centres, half_sizes) -> Chunks:
    """Chunks of three indices each, in two batches, none of them neighbours."""
    n = len(centres)
    return Chunks(
        np.arange(n) * 10,
        np.full(n, 3),
        np.arange(n) % 2,
        boxes_of(np.array(centres, float), np.array(half_sizes, float)),
    )


def drawn(draws) -> set[int]:
    """Numbers of the chunks of chunks_of."""
    return {first // 10 for _, spans in draws for first, _ in spans}


boxes = st.lists(
    st.tuples(st.tuples(*[st.floats(-20, 20)] * 3), st.tuples(*[st.floats(0.01, 3)] * 3)), min_size=1, max_size=30
)


@given(boxes, near, turns, fovs)
def test_all_that_a_view_sees_is_drawn(boxes, position, turn, fov):
    chunks, view = chunks_of(*zip(*boxes, strict=True)), View(Pose(position, turn), fov)
    exact = visible(chunks.boxes, clip_from_eye(fov) @ eye_from_scene(view, np.zeros(3)))
    found = drawn(Visibility(chunks).near(view.pose.unit_quaternion, view.pose.position_m, fov))
    assert set(exact.nonzero()[0].tolist()) <= found


@given(boxes, near, turns, fovs)
def test_a_quaternion_and_its_negative_are_one_turn(boxes, position, turn, fov):
    sights, eye = Visibility(chunks_of(*zip(*boxes, strict=True))), np.array(position)
    there = Pose(position, turn).unit_quaternion
    if abs(there[3]) > 1e-6:  # at a half turn the two may lie in two cells, which may hold a little more each
        assert sights.near(there, eye, fov) is sights.near(tuple(-q for q in there), eye, fov)


def test_the_order_does_not_depend_on_what_was_drawn_before():
    rng = np.random.default_rng(4)
    chunks, fov = chunks_of(rng.uniform(-9, 9, (200, 3)), rng.uniform(0.1, 1, (200, 3))), Fov.symmetric(1.6, 1.5)
    views = [(Pose((0, 0, 0), rng.normal(size=4)).unit_quaternion, rng.uniform(-3, 3, 3)) for _ in range(3 * KEPT)]
    kept = Visibility(chunks)
    there = [kept.near(turn, eye, fov) for turn, eye in views]
    back = [kept.near(turn, eye, fov) for turn, eye in reversed(views)]
    assert there == back[::-1]
    assert len(kept._known) == KEPT


def test_every_chunk_is_drawn_once_and_neighbours_in_one_call():
    first = np.array([0, 3, 6, 20])
    chunks = Chunks(first, np.full(4, 3), np.array([0, 0, 0, 1]), boxes_of(np.zeros((4, 3)), np.ones((4, 3))))
    assert draws_of(chunks, np.ones(4, bool), np.zeros(3)) == ((0, ((0, 9),)), (1, ((20, 3),)))
    assert draws_of(chunks, np.zeros(4, bool), np.zeros(3)) == ()


def test_little_more_is_drawn_than_is_seen(serve):
    """Of the room, over a look around: its triangles are what drawing costs on a processor."""
    server = serve("room")
    chunks, fov = server._buffers.chunks, Fov.symmetric(math.radians(90), math.radians(100))
    seen = cell = cells = 0
    for k in range(180):
        turn = math.radians(2 * k)
        view = View(Pose((0.3 * math.sin(turn), 1.6, 0.2), (0, math.sin(turn / 2), 0, math.cos(turn / 2))), fov)
        exact = visible(chunks.boxes, clip_from_eye(fov) @ eye_from_scene(view, server.scene.origin_m))
        known = len(server._buffers.visibility._known)
        draws = server._buffers.visibility.near(
            view.pose.unit_quaternion, view.pose.position_m - server.scene.origin_m, fov
        )
        cells += len(server._buffers.visibility._known) != known
        seen += chunks.count[exact].sum()
        cell += sum(count for _, spans in draws for _, count in spans)
    print(f"{cell / seen:.3f} times the triangles")
    assert seen <= cell <= 1.25 * seen
