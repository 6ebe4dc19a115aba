"""Layers that a caller gives beside colour and depth: each does what its effect says."""

from __future__ import annotations

import attrs
import numpy as np
import pytest

from hmdwarp import Fov, InputError, Panel, Pose, View, Warper, warp_image
from hmdwarp.base import PlanError

WIDE, HIGH = 40, 30
FAR_M, NEAR_M = 8.0, 2.0
# 20 pixels per tangent: 0.2 m at 2 m are 2 pixels.
HERE = View(Pose(), Fov.from_tangents((-1.0, 1.0, -0.75, 0.75)))
PATCH = slice(10, 20)
RED, BLUE = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)


@pytest.fixture
def picture():
    """A red strip before a blue wall."""
    colour, depth = np.empty((HIGH, WIDE, 3)), np.full((HIGH, WIDE), FAR_M)
    colour[:] = BLUE
    colour[:, PATCH], depth[:, PATCH] = RED, NEAR_M
    return colour, depth


def moved_right_by_two(colour: np.ndarray) -> bool:
    red = colour[HIGH // 2, :, 0] > 0.5
    return np.array_equal(np.flatnonzero(red), np.arange(PATCH.start + 2, PATCH.stop + 2))


def test_deforming_pixels_go_on_with_their_velocity(picture, gpu):
    """In 0.2 s a swing goes as far as 0.16 s of its speed: 1.25 m/s make 0.2 m."""
    velocity = np.zeros((HIGH, WIDE, 3))
    velocity[:, PATCH, 0] = 1.25
    more = {"effects": "soft_motion", "layers": {"velocity": velocity}, "fill": "pyramid", "gpu": gpu}
    assert moved_right_by_two(warp_image(*picture, HERE, HERE, age_s=0.2, **more).colour)
    assert np.allclose(warp_image(*picture, HERE, HERE, **more).colour, picture[0], atol=1e-3)  # no age, no motion


@pytest.mark.parametrize(
    ("effects", "layers", "told"),
    [
        ("soft_motion", {}, "warp 'iterative' with effect 'soft_motion' reads layer 'velocity': give layers"),
        ("none", {"velocity": 0}, "layer 'velocity': warp 'iterative' does not read it"),
        ("none", {"normals": 0}, "layer 'normals' is unknown: expected velocity, panels"),
        ("none", {"panels": []}, "layer 'panels': warp 'iterative' does not read it"),
        ("none", {"cube": 0}, "layer 'cube' comes from a server or the feed alone: expected"),
        ("panels", {"panels": [0]}, r"layer 'panels' is a list: expected \[hmdwarp.Panel.picture, pose, size_m"),
        ("panels", {"panels": 0}, "layer 'panels' is a int: expected .hmdwarp.Panel"),
        ("soft_motion", {"velocity": np.zeros((3, 3, 3))}, "layer 'velocity' is float64 .3, 3, 3.: expected numbers"),
        ("soft_motion", {"velocity": np.full((HIGH, WIDE, 3), np.nan)}, "layer 'velocity' has NaN"),
    ],
)
def test_a_layer_that_is_missing_or_wrong_is_named(picture, gpu, effects, layers, told):
    with pytest.raises(InputError, match=told):
        warp_image(*picture, HERE, HERE, effects=effects, layers=layers, gpu=gpu)


def test_effects_of_a_scene_stay_refused(picture, gpu):
    for needs in ("ids", "overlay"):
        with pytest.raises(PlanError, match=f"layer .{needs}. from the server"):
            warp_image(*picture, HERE, HERE, effects="rigid_motion" if needs == "ids" else needs, gpu=gpu)
    with pytest.raises(PlanError, match="layer .light. from the server .* the scene.s geometry on the client"):
        warp_image(*picture, HERE, HERE, effects="light_only", gpu=gpu)
    with pytest.raises(InputError, match="age_s is inf"):
        warp_image(*picture, HERE, HERE, age_s=np.inf, gpu=gpu)


VIEW = View(Pose((0.0, 1.6, 0.0)), Fov.from_tangents((-0.64, 0.64, -0.48, 0.48)))
SHOWN = attrs.evolve(VIEW, pose=Pose((0.1, 1.6, 0.0)))
GREY = np.full((48, 64, 3), 99, np.uint8)
# 2 m away; a post in front of the left half of what is shown
BEHIND_A_POST = np.where(np.arange(64) < 32, 0.8, 2.0) * np.ones((48, 1))
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
    still = {"rendered": VIEW, "shown": VIEW, "colour": GREY, "depth_m": BEHIND_A_POST}
    panel = attrs.evolve(WHITE, pose=Pose((0.0, 1.6, -1.0)), occluded=True)
    hidden = warp_image(**still, **laid(panel)).colour == 255
    assert not hidden[:, :32].any()
    assert hidden[14:34, 33:42].all()
    assert (warp_image(**still, **laid(attrs.evolve(panel, occluded=False))).colour == 255)[14:34, 22:42].all()


def test_a_warper_takes_other_panels_for_each_picture():
    arguments = GREY, np.full((48, 64), 2.0), VIEW, SHOWN
    with Warper((64, 48), effects="panels") as warper:
        bare, one = warper.warp(*arguments), warper.warp(*arguments, layers={"panels": [WHITE]})
        beside = warper.warp(*arguments, layers={"panels": [attrs.evolve(WHITE, pose=Pose((0.3, 1.6, -1.0))), WHITE]})
        again = warper.warp(*arguments)
    assert np.array_equal(one.colour, warped(WHITE))
    assert np.array_equal(bare.colour, again.colour)
    assert (beside.colour == 255).all(axis=2).sum() == 20 * 30
