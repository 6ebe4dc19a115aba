"""The environment warp. Every direction is covered, edges and corners show no seam, and a step
changes nothing."""

from __future__ import annotations

import numpy as np
import pytest
from worlds import World, shown_by

from hmdwarp.base import PlanError
from hmdwarp.client import PassInputs
from hmdwarp.geometry import View
from hmdwarp.geometry.cube import FACES

SIZE = (61, 53)


def looked(gpu, rendered, shown: View, size=SIZE) -> np.ndarray:
    return shown_by(gpu, "environment", PassInputs(rendered, shown), size)[0]


@pytest.fixture
def world(gpu):
    made = World(gpu, 2, SIZE)
    made.bring_cube(gpu)
    return made


@pytest.mark.parametrize("index", range(6), ids=[face.name for face in FACES])
@pytest.mark.parametrize("margin", [0, 5])
def test_a_view_along_a_face_is_copied_bit_for_bit(gpu, world, index, margin):
    wanted = world.look_along_a_face(gpu, index, margin)
    assert np.array_equal(world.warp(gpu, "environment"), wanted)


def test_a_frame_without_a_cube_is_refused_with_the_reason(gpu, world):
    with pytest.raises(PlanError, match="needs a cube map around the eye"):
        looked(gpu, world.rendered.having(cube=None), world.shown_view)
