"""Backward's depth test.

What the rendered picture did not see stays empty, at the border of the picture too.
"""

from __future__ import annotations

import numpy as np
import pytest

from hmdwarp.client import build_plan
from hmdwarp.client.warp_kinds import DEPTH_FLOOR, DEPTH_TOLERANCE
from hmdwarp.frames import EyeSizes, frame_bytes
from hmdwarp.geometry import Pose

from .rendered_pictures import FOV, warped


def backward(gpu, depth: np.ndarray, own: np.ndarray, pose: Pose, depth_error: float = 0.0) -> np.ndarray:
    """What the eye at `pose` sees of something white; own: the client's own depth."""
    return warped(gpu, "backward", np.ones((*depth.shape, 4)), depth, pose, client_depth=own, depth_error=depth_error)


@pytest.mark.parametrize("turn", [(0, 0.01, 0), (0.02, 0, 0), (0.01, -0.02, 0.3), (0, 0, 0)])
@pytest.mark.parametrize("rendered", [1.0, -1.0])
def test_sky_that_was_behind_a_wall_stays_empty_up_to_the_border(gpu, turn, rendered):
    """Beyond the border of the rendered picture there is no depth, and above all not that of the
    sky.
    """
    size = (13, 11)
    got = backward(gpu, np.full(size[::-1], rendered), np.zeros(size[::-1]), Pose(orientation_xyzw=(*turn, 1)))
    assert (got == 0).all()


def test_without_the_test_the_rendered_depth_is_not_in_the_frame(gpu):
    plan = build_plan((), "backward:test=off", "interpolate", "none", client_geometry=True)
    assert plan.layers == ("rendered.colour",)
    assert plan.draws_client_depth
    sizes = EyeSizes((40, 30), (40, 30), (FOV, FOV))
    with_test = build_plan((), "backward", "interpolate", "none", client_geometry=True)
    weights = [frame_bytes(tried.needs, sizes, tried.layers) for tried in (plan, with_test)]
    assert set(weights[1]) - set(weights[0]) == {"rendered.inverse_depth"}
    assert sum(weights[1].values()) - sum(weights[0].values()) == 2 * 4 * 40 * 30
    # A fill that reads the shown picture's depth gets it from the warp.
    filled = build_plan((), "backward:test=off", "pyramid", "none", client_geometry=True)
    assert filled.layers == plan.layers


@pytest.mark.parametrize("share", [0.98, 1.02])
@pytest.mark.parametrize("own", [0.05, 0.5, 2.0])
@pytest.mark.parametrize("side", [-1, 1])
def test_the_tolerance_is_where_it_says(gpu, own, share, side):
    limit = DEPTH_TOLERANCE * (own + DEPTH_FLOOR)
    rendered = own + side * limit * share
    got = backward(gpu, np.full((5, 5), rendered), np.full((5, 5), own), Pose())
    assert (got[..., 3] == (share < 1)).all()


def test_without_own_depth_nothing_is_known(gpu):
    got = backward(gpu, np.full((5, 5), 0.5), np.full((5, 5), -1.0), Pose((0.01, 0, 0)))
    assert (got == 0).all()


def test_depth_that_was_coded_coarsely_leaves_no_holes_where_the_frame_says_so(gpu):
    """Half a step of 2^-7 is more than the test allows at 10 m: 0.03 * (0.1 + 0.02) per metre."""
    size, depth, wrong = (13, 11), 0.1, 2.0**-8
    own, coded = (np.full(size[::-1], value) for value in (depth, depth + wrong))
    assert (backward(gpu, coded, own, Pose())[..., 3] == 0).all()
    assert (backward(gpu, coded, own, Pose(), depth_error=wrong)[..., 3] == 1).all()
    behind = np.full(size[::-1], depth + 3 * wrong)
    assert (backward(gpu, behind, own, Pose(), depth_error=wrong)[..., 3] == 0).all()
