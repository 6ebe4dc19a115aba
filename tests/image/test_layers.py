"""Layers that a caller gives beside colour and depth: each does what its effect says."""

from __future__ import annotations

import numpy as np
import pytest

from hmdwarp import Fov, InputError, Pose, View, warp_image
from hmdwarp.errors import PlanError

SIZE = WIDE, HIGH = 40, 30
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
