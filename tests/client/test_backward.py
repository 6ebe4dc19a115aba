"""Backward's depth test.

What the rendered picture did not see stays empty, at the border of the picture too.
"""

from __future__ import annotations

import numpy as np
import pytest

from hmdwarp.client import PassInputs, build_plan
from hmdwarp.client.warp_kinds import DEPTH_FLOOR, DEPTH_TOLERANCE
from hmdwarp.client.warps import warps
from hmdwarp.client.warps.backward import BackwardSettings
from hmdwarp.frames import EyeImage, EyeSizes, frame_bytes
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import COLOUR, SCALAR, Canvas, allocate

FOV = Fov.from_tangents([-1, 1, -1, 1])


def backward(
    gpu,
    colour: np.ndarray,
    rendered_depth: np.ndarray,
    client_depth: np.ndarray,
    pose: Pose,
    rendered_pose: Pose | None = None,
    settings: BackwardSettings | None = None,
    depth_error: float = 0.0,
) -> np.ndarray:
    """(h, w, 4) what the eye at `pose` sees; all pictures bottom row first, (h, w[, 4])."""
    size, shown_size = rendered_depth.shape[::-1], client_depth.shape[::-1]
    textures = [allocate(gpu.gl, size, COLOUR), allocate(gpu.gl, size, SCALAR), allocate(gpu.gl, shown_size, SCALAR)]
    for texture, picture, dtype in zip(
        textures, (colour, rendered_depth, client_depth), (np.float16, np.float32, np.float32), strict=True
    ):
        texture.write(np.ascontiguousarray(picture, dtype).tobytes(), alignment=1)
    canvas = Canvas(gpu.gl, shown_size)
    rendered = EyeImage(View(rendered_pose or Pose(), FOV), *textures[:2], depth_error=depth_error)
    warps.get("backward")(gpu, size, shown_size, settings).run(
        PassInputs(rendered, View(pose, FOV), client_inverse_depth=textures[2]), canvas
    )
    gpu.gl.memory_barrier()
    out = np.frombuffer(canvas.texture.read(alignment=1), np.float16).reshape(*client_depth.shape, 4).astype(np.float64)
    for thing in (*textures, canvas):
        thing.release()
    return out


def white(size: tuple[int, int]) -> np.ndarray:
    return np.ones((size[1], size[0], 4))


@pytest.mark.parametrize("turn", [(0, 0.01, 0), (0.02, 0, 0), (0.01, -0.02, 0.3), (0, 0, 0)])
@pytest.mark.parametrize("rendered", [1.0, -1.0])
def test_sky_that_was_behind_a_wall_stays_empty_up_to_the_border(gpu, turn, rendered):
    """Beyond the border of the rendered picture there is no depth, and above all not that of the
    sky.
    """
    size = (13, 11)
    got = backward(
        gpu, white(size), np.full(size[::-1], rendered), np.zeros(size[::-1]), Pose(orientation_xyzw=(*turn, 1))
    )
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
    got = backward(gpu, white((5, 5)), np.full((5, 5), rendered), np.full((5, 5), own), Pose())
    assert (got[..., 3] == (share < 1)).all()


def test_without_own_depth_nothing_is_known(gpu):
    got = backward(gpu, white((5, 5)), np.full((5, 5), 0.5), np.full((5, 5), -1.0), Pose((0.01, 0, 0)))
    assert (got == 0).all()


def test_depth_that_was_coded_coarsely_leaves_no_holes_where_the_frame_says_so(gpu):
    """Half a step of 2^-7 is more than the test allows at 10 m: 0.03 * (0.1 + 0.02) per metre."""
    size, depth, wrong = (13, 11), 0.1, 2.0**-8
    own, coded = (np.full(size[::-1], value) for value in (depth, depth + wrong))
    assert (backward(gpu, white(size), coded, own, Pose())[..., 3] == 0).all()
    assert (backward(gpu, white(size), coded, own, Pose(), depth_error=wrong)[..., 3] == 1).all()
    behind = np.full(size[::-1], depth + 3 * wrong)
    assert (backward(gpu, white(size), behind, own, Pose(), depth_error=wrong)[..., 3] == 0).all()
