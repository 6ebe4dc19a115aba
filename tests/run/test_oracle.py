"""The oracle takes each pixel from where its true surface was in the late frame."""

from __future__ import annotations

import numpy as np
import pytest

from hmdwarp import Fov, Pose, View
from hmdwarp.geometry import WarpMap
from hmdwarp.run.side_by_side import from_late

SIZE, WALL = (40, 30), 0.5  # 2 m away
FOV = Fov.symmetric(1.2, 0.9)


def test_a_wall_seen_from_beside_is_shown_exactly_where_the_late_frame_saw_it():
    """A picture that is linear across the wall is sampled exactly between its pixels."""
    shown, rendered = View(Pose((0.1, 0, 0)), FOV), View(Pose(), FOV)
    x = np.broadcast_to(np.arange(SIZE[0]) + 0.5, SIZE[::-1])
    late = np.repeat(x[..., None], 3, axis=2)
    wall = np.full(SIZE[::-1], WALL)
    colour, seen = from_late(WarpMap.between(shown, SIZE, rendered, SIZE), wall, late, wall)
    left, right, _, _ = FOV.tangents
    moved = 0.1 * WALL * SIZE[0] / (right - left)  # pixels
    inside = x + moved <= SIZE[0] - 0.5
    assert seen[inside].all() and not seen[~inside].any() and not inside.all()
    assert colour[inside][:, 0] == pytest.approx((x + moved)[inside])


def test_what_stood_behind_something_nearer_was_not_seen():
    here = View(Pose(), FOV)
    wall = np.full(SIZE[::-1], WALL)
    late_depth = wall.copy()
    late_depth[10:20, 5:15] = 2 * WALL
    late = np.zeros((*SIZE[::-1], 3))
    _, seen = from_late(WarpMap.between(here, SIZE, here, SIZE), wall, late, late_depth)
    inner = seen[1:-1, 1:-1]
    assert np.array_equal(~inner, late_depth[1:-1, 1:-1] == 2 * WALL)
