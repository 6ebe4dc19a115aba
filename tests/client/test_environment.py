"""The environment warp. Every direction is covered, edges and corners show no seam, and a step
changes nothing."""

from __future__ import annotations

import math

import numpy as np
import pytest
from reference._rays import world_directions
from scipy.spatial.transform import Rotation
from worlds import World, shown_by

from hmdwarp.client import PassInputs
from hmdwarp.errors import PlanError
from hmdwarp.geometry import Fov, Pose, View, face_views
from hmdwarp.geometry.cube import FACES

SIZE = (61, 53)
FOV = Fov.symmetric(1.4, 1.3)


def looked(gpu, rendered, shown: View, size=SIZE) -> np.ndarray:
    return shown_by(gpu, "environment", PassInputs(rendered, shown), size)[0]


@pytest.fixture
def world(gpu):
    made = World(gpu, 2, SIZE)
    made.bring_cube(gpu)
    return made


def paint(gpu, world, colour_of) -> None:
    """A cube whose every pixel is a function (n, 3) -> (n, 3) of the unit direction in the eye it
    looks along, borders included."""
    side = max(SIZE) + 2
    for face, view in zip(FACES, face_views(View(Pose(), FOV), side), strict=True):
        rays = world_directions(view, (side, side))
        colour = colour_of(rays / np.linalg.norm(rays, axis=-1, keepdims=True))
        world.cube[face.row * side : (face.row + 1) * side, face.column * side : (face.column + 1) * side, :3] = colour
    world.bring_cube(gpu)


@pytest.mark.parametrize("index", range(6), ids=[face.name for face in FACES])
@pytest.mark.parametrize("margin", [0, 5])
def test_a_view_along_a_face_is_copied_bit_for_bit(gpu, world, index, margin):
    wanted = world.look_along_a_face(gpu, index, margin)
    assert np.array_equal(world.warp(gpu, "environment"), wanted)


def test_no_seam_at_edges_and_corners(gpu, world):
    """A smooth pattern, looked at closely across a corner. No step between neighbours is larger
    than the pattern's steepest."""
    paint(gpu, world, lambda d: 1 + np.sin(3 * d))
    pose = world.rendered_view.pose
    for yaw, pitch in ((45, math.degrees(math.atan(math.sqrt(0.5)))), (45, 0), (0, 45), (135, -35), (-45, 35)):
        turn = Rotation.from_euler("YX", [yaw, pitch], degrees=True)
        fov = Fov.symmetric(0.2, 0.2)
        out = looked(gpu, world.rendered, View(Pose(pose.position_m, (pose.rotation * turn).as_quat()), fov))
        for axis in (0, 1):
            step = np.abs(np.diff(out[..., :3], axis=axis)).max()
            # slope 3 per radian; a face's chord of one pixel may be off the curve by 9/8 of its
            # square at either side; half floats below 2
            assert step <= 3 * 0.21 / SIZE[1 - axis] + 9 / 4 * (2 / max(SIZE)) ** 2 + 2 * 2.0**-10


def test_a_frame_without_a_cube_is_refused_with_the_reason(gpu, world):
    with pytest.raises(PlanError, match="needs a cube map around the eye"):
        looked(gpu, world.rendered.having(cube=None), world.shown_view)
