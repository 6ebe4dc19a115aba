"""Panels over a caller's own picture."""

from __future__ import annotations

import attrs
import numpy as np

from hmdwarp import Fov, Panel, Pose, View, Warper, warp_image

SIZE = (64, 48)
VIEW = View(Pose((0.0, 1.6, 0.0)), Fov.from_tangents((-0.64, 0.64, -0.48, 0.48)))
SHOWN = attrs.evolve(VIEW, pose=Pose((0.1, 1.6, 0.0)))
GREY = np.full((48, 64, 3), 99, np.uint8)
# 2 m away; a post in front of the left half of what is shown
DEPTH = np.where(np.arange(64) < 32, 0.8, 2.0) * np.ones((48, 1))
WHITE = Panel(np.full((8, 8, 3), 255, np.uint8), Pose((0.1, 1.6, -1.0)), (0.4, 0.4))


def laid(*panels, effects="panels,occluded_panels"):
    return {"layers": {"panels": panels}, "effects": effects}


def warped(*panels):
    return warp_image(GREY, np.full((48, 64), 2.0), VIEW, SHOWN, **laid(*panels)).colour


def test_a_panel_stands_where_the_newest_eye_sees_it():
    """0.4 m in 1 m are 20 pixels of 0.02, around the middle: the eye is before it."""
    found = warped(WHITE)
    expected = np.zeros((48, 64), bool)
    expected[14:34, 22:42] = True
    assert np.array_equal((found == 255).all(axis=2), expected)
    assert np.array_equal(found[~expected], warped()[~expected])


def test_what_is_nearer_hides_a_panel_that_asks_for_it():
    still = {"rendered": VIEW, "shown": VIEW, "colour": GREY, "depth_m": DEPTH}
    panel = attrs.evolve(WHITE, pose=Pose((0.0, 1.6, -1.0)), occluded=True)
    hidden = warp_image(**still, **laid(panel)).colour == 255
    assert not hidden[:, :32].any()
    assert hidden[14:34, 33:42].all()
    assert (warp_image(**still, **laid(attrs.evolve(panel, occluded=False))).colour == 255)[14:34, 22:42].all()


def test_a_warper_takes_other_panels_for_each_picture():
    arguments = GREY, np.full((48, 64), 2.0), VIEW, SHOWN
    with Warper(SIZE, effects="panels") as warper:
        bare, one = warper.warp(*arguments), warper.warp(*arguments, layers={"panels": [WHITE]})
        beside = warper.warp(*arguments, layers={"panels": [attrs.evolve(WHITE, pose=Pose((0.3, 1.6, -1.0))), WHITE]})
        again = warper.warp(*arguments)
    assert np.array_equal(one.colour, warped(WHITE))
    assert np.array_equal(bare.colour, again.colour)
    assert (beside.colour == 255).all(axis=2).sum() == 20 * 30
