"""Gather warps where their homography says more than the picture.

Behind the eye, through the plane, without a turn.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from hmdwarp.geometry import Pose

from . import rendered_pictures

SIZE = (19, 13)


def warped(
    gpu, name: str, shown: Pose, depth: float, seed: int | None = None, rendered: Pose | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """(h, w, 4) the rendered picture (white, or noise) and the shown one, bottom row first."""
    picture = np.ones((SIZE[1], SIZE[0], 4))
    if seed is not None:
        picture[..., :3] = np.random.default_rng(seed).uniform(0, 1, (SIZE[1], SIZE[0], 3))
    picture = picture.astype(np.float16).astype(np.float64)
    return picture, rendered_pictures.warped(gpu, name, picture, np.full(SIZE[::-1], depth), shown, rendered)


def test_an_eye_that_has_passed_the_plane_sees_nothing_ahead_and_the_plane_behind(gpu):
    """The plane lies 2 m ahead of the rendered eye; the shown one stands 3 m ahead."""
    _, out = warped(gpu, "planar", Pose((0, 0, -3)), 0.5)
    assert (out == 0).all()
    turned = Pose((0, 0, -3), (0, 1, 0, 0))
    _, out = warped(gpu, "planar", turned, 0.5)
    assert (out == 1).all(), "looking back from 1 m behind it, the plane fills the view"


@pytest.mark.parametrize("name", ["rotation", "shift", "none"])
def test_a_step_without_a_turn_keeps_the_picture_bit_for_bit(gpu, name):
    q = np.array([0.1, -0.2, 0.3, 0.9])
    picture, out = warped(gpu, name, Pose((1.5, -0.3, 2.0), q), 0.5, seed=1, rendered=Pose((0.2, 0.1, 0), q))
    assert np.array_equal(out, picture)


def test_a_clamped_edge_goes_on_beyond_the_border(gpu):
    """A quarter turn of the view's width: what was not rendered has the border's colour, and what
    is behind the rendered eye stays empty.
    """
    half = math.atan(0.5) / 2
    pose = Pose(orientation_xyzw=(0, -math.sin(half), 0, math.cos(half)))
    picture, empty = warped(gpu, "rotation", pose, 0.5, seed=4)
    _, clamped = warped(gpu, "rotation:edge=clamp", pose, 0.5, seed=4)
    inside = empty[..., 3] > 0
    assert 0.1 < 1 - inside.mean() < 0.5
    assert (clamped[..., 3] == 1).all() and np.array_equal(clamped[inside], empty[inside])
    # A turn to the right about the vertical: rows far from the middle are looked up a little
    # nearer to it or farther, so each is a mean of two pixels of the right border.
    right = picture[:, -1, :3].astype(float)
    beyond = clamped[..., :3][~inside].astype(float)
    assert (beyond >= right.min(axis=0) - 2.0**-10).all() and (beyond <= right.max(axis=0) + 2.0**-10).all()
    back = Pose(orientation_xyzw=(0, 1, 0, 0))
    assert (warped(gpu, "rotation:edge=clamp", back, 0.5)[1] == 0).all()


def test_none_ignores_the_turn_too(gpu):
    picture, out = warped(gpu, "none", Pose((1, 2, 3), (0.3, 0.4, 0.1, 0.8)), 0.5, seed=2)
    assert np.array_equal(out, picture)
