"""Labels: none covers another, a point, or a leader.

And names beside lines keep their order and distance.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmdwarp.report import boxes_touch, leaders, place_labels, segments_hit, spread

AREA = (650.0, 260.0)


def placed(points, sizes):
    corners = place_labels(list(points), sizes, AREA)
    return np.concatenate([corners, corners + sizes], axis=1)


@pytest.mark.parametrize(
    "count, spread_of_points", [(0, 0.1), (1, 0.1), (15, 0.05), (30, 0.1), (15, 0.2), (30, 0.2), (45, 0.2)]
)
def test_labels_cover_nothing(count, spread_of_points):
    """As many as the bench has, from crowded to loose.

    45 names of these sizes fill a quarter of the area.
    """
    rng = np.random.default_rng(count)
    points = np.clip(0.5 + spread_of_points * rng.standard_normal((count, 2)), 0.02, 0.98) * AREA
    sizes = np.stack([rng.uniform(25, 80, count), np.full(count, 11.0)], axis=1)
    boxes = placed(points, sizes)
    own = np.eye(count, dtype=bool)
    assert not (boxes_touch(boxes, boxes) & ~own).any()
    assert (boxes[:, :2] >= 0).all() and (boxes[:, 2:] <= AREA).all()
    if (
        spread_of_points < 0.2
        # Dozens of markers, 8 wide, within a tenth of the area: leaders may have to pass a label.
    ):
        return
    assert not boxes_touch(boxes, np.concatenate([points - 4, points + 4], axis=1)).any()
    tips = np.concatenate([np.zeros((0, 2)), *(leaders(points[[i]], boxes[[i]])[1] for i in range(count))])
    assert not (segments_hit(points, tips, boxes) & ~own).any()


@pytest.mark.parametrize("crowd", [5, 22, 27, 31, 32])
def test_names_that_are_in_the_way_make_room(crowd):
    """A staircase of names among other points: each finds a place within its greatest width.

    In these crowds one stands farther off, if none moves on for another.
    """
    rng = np.random.default_rng(crowd)
    across, up = np.sort(rng.normal(80, 30, 10)), 150 - np.sort(rng.normal(80, 25, 10))
    points = np.stack([across, up], axis=1).clip(8, 190)
    sizes = np.stack([rng.uniform(30, 90, 10), rng.choice([11.0, 22.0], 10)], axis=1)
    others = rng.uniform((20, 60), (180, 140), (14, 2))
    corners = place_labels(list(points), sizes, (260, 180), others=others)
    boxes = np.concatenate([corners, corners + sizes], axis=1)
    ends = [leaders(points[[i]], boxes[[i]]) for i in range(10)]
    assert max(np.linalg.norm(tip - start) for (start,), (tip,) in ends) <= 90


def test_equal_points_get_labels_of_their_own():
    points, sizes = np.full((6, 2), 100.0), np.tile([60.0, 11.0], (6, 1))
    boxes = placed(points, sizes)
    assert (boxes_touch(boxes, boxes) == np.eye(6, dtype=bool)).all()


def test_a_lonely_label_stands_right_beside_its_point():
    (box,) = placed(np.array([[100.0, 100.0]]), np.array([[60.0, 11.0]]))
    assert box[0] - 100 < 6 and box[1] < 100 < box[3]


def test_too_many_labels_still_have_places():
    corners = place_labels(list(np.full((30, 2), 20.0)), np.full((30, 2), 30.0), (60, 60))
    assert np.isfinite(corners).all()


def test_the_same_twice():
    rng = np.random.default_rng(1)
    points, sizes = rng.uniform(0, 200, (20, 2)), rng.uniform(8, 60, (20, 2))
    assert np.array_equal(placed(points, sizes), placed(points, sizes))


def test_a_label_of_several_points_stands_beside_one_of_them_and_covers_none():
    points = np.array([[100.0, 100.0], [108.0, 104.0], [112.0, 96.0]])
    corners = place_labels([points, np.array([[160.0, 100.0]])], np.array([[60.0, 11.0], [60.0, 11.0]]), AREA)
    boxes = np.concatenate([corners, corners + (60, 11)], axis=1)
    starts, tips = leaders(points, boxes[:1])
    assert np.linalg.norm(starts - tips) < 8 and starts[0] in points
    assert (
        not boxes_touch(boxes, np.concatenate([points - 4, points + 4], axis=1)).any()
        and not boxes_touch(boxes[:1], boxes[1:]).any()
    )


COORDINATES = st.tuples(st.integers(-4, 4), st.integers(-4, 4))


@given(COORDINATES, COORDINATES)
def test_segments_through_a_box(start, end):
    """Against many points along the segment.

    The box has half-integer sides, so that none of them is a matter of rounding.
    """
    start, end, box = np.array([start], float), np.array([end], float), np.array([[-1.5, -0.5, 2.5, 1.5]])
    along = (
        start + (end - start) * np.linspace(0, 1, 1681)[:, None]
    )  # every crossing of a half-integer line lies between two of these
    within = ((along > box[0, :2]) & (along < box[0, 2:])).all(axis=1).any()
    hit = segments_hit(start, end, box)[0, 0]
    assert hit or not within
    # It cuts a corner between two samples: then it comes as near as a sample's step to the box.
    if hit and not within:
        step = np.linalg.norm(end - start) / 1680
        assert np.linalg.norm(along - np.clip(along, box[0, :2], box[0, 2:]), axis=1).min() <= step


@given(st.lists(st.floats(-50, 150), max_size=20), st.floats(0, 12))
def test_names_beside_lines_keep_order_distance_and_bounds(wanted, gap):
    out = spread(np.array(wanted), gap, 0, 100)
    order = np.argsort(wanted, kind="stable")
    possible = min(gap, 100 / max(len(wanted) - 1, 1))
    assert (np.diff(out[order]) >= possible - 1e-9).all()
    assert (out >= -1e-9).all() and (out <= 100 + 1e-9).all()


def test_names_with_room_stay_where_they_are():
    assert spread(np.array([30.0, 10.0, 80.0]), 10, 0, 100).tolist() == [30, 10, 80]
    assert spread(np.array([50.0, 50.0]), 10, 0, 100).tolist() == [45, 55]
