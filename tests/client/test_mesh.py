"""The mesh: a floor to the horizon, what is cut where, and how far a point may move."""

from __future__ import annotations

import numpy as np
import pytest

from hmdwarp.client.warp_kinds import steepest
from hmdwarp.client.warp_kinds.mesh import reach
from hmdwarp.geometry import Fov, Pose, View, WarpMap

from .rendered_pictures import warped

SIZE = (64, 48)
FOV = Fov(*np.deg2rad([-45, 45, -40, 40]))


@pytest.mark.parametrize("spec", ["mesh", "mesh_adaptive"])
def test_a_floor_to_the_horizon_stays_whole(gpu, spec):
    """Its last rows are much steeper than any limit.

    That they go on straight is what keeps them together.
    """
    down, up = FOV.tangents[2:]
    tangent = down + (up - down) * (np.arange(SIZE[1]) + 0.5) / SIZE[1]
    floor = np.broadcast_to(np.maximum(-tangent / 1.6, 0)[:, None], SIZE[::-1])  # 1.6 m below; sky above
    out = warped(gpu, spec, np.ones((*SIZE[::-1], 4)), floor, Pose((0.15, 0.3, 0)), fov=FOV)
    assert (out[:, 8:-8, 3] == 1).all()


def test_the_limit_is_a_plane_at_that_angle():
    """A plane turned by 80 degrees about the vertical axis.

    Inverse depth along the middle row, by its geometry.
    """
    view, angle = View(Pose(), FOV), np.deg2rad(80)
    rays = view.rays((1001, 1))[0]
    normal = np.array([np.sin(angle), 0, np.cos(angle)])
    inverse = rays @ -normal / 2.0
    middle = inverse[500]
    assert abs(inverse[501] - inverse[500]) / middle == pytest.approx(steepest(view, (1001, 1), 80.0)[0], rel=1e-6)


def test_reach_bounds_how_far_depth_moves_a_point():
    rng = np.random.default_rng(2)
    for _ in range(20):
        rendered = View(Pose(rng.normal(size=3), rng.normal(size=4)), FOV)
        turn = Pose(rng.normal(scale=0.1, size=3), (*rng.normal(scale=0.05, size=3), 1))
        shown = View(rendered.pose @ turn, FOV)
        forward = WarpMap.between(rendered, SIZE, shown, SIZE)
        place = rng.uniform([0, 0], SIZE, (500, 2))
        before, _, w = forward.apply(place, np.full(500, 0.3))
        after, _, _ = forward.apply(place, np.full(500, 0.3 + 1e-6))
        inside = ((before >= 0) & (before <= SIZE)).all(axis=1)
        moved = np.linalg.norm(after - before, axis=1) * w / 1e-6
        assert (moved[inside] <= reach(forward, SIZE) * (1 + 1e-3)).all()
