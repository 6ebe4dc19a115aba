"""Layers that a caller gives beside colour and depth: each does what its effect says."""

from __future__ import annotations

import numpy as np
import pytest

from hmdwarp import Fov, InputError, Pose, View, Warper, warp_image
from hmdwarp.errors import PlanError
from hmdwarp.geometry import RigidState
from hmdwarp.gpu import COLOUR, SCALAR, allocate

SIZE = WIDE, HIGH = 40, 30
FAR_M, NEAR_M = 8.0, 2.0
# 20 pixels per tangent: 0.2 m at 2 m are 2 pixels.
HERE = View(Pose(), Fov.from_tangents((-1.0, 1.0, -0.75, 0.75)))
PATCH = slice(10, 20)
RED, BLUE = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
BODY = RigidState(Pose())


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


def test_a_body_goes_on_with_its_pose(picture, gpu):
    numbers = np.zeros((HIGH, WIDE), int)
    numbers[:, PATCH] = 1
    bodies = [RigidState(Pose((0, 0, -NEAR_M)), velocity_m_s=(1.0, 0, 0))]
    with Warper(SIZE, effects="rigid_motion", gpu=gpu) as warper:
        out = warper.warp(*picture, HERE, HERE, layers={"ids": (numbers, bodies)}, age_s=0.2)
    assert moved_right_by_two(out.colour)


@pytest.mark.parametrize("as_bytes", [False, True])
def test_an_overlay_lies_over_the_result_and_is_never_warped(picture, gpu, as_bytes):
    overlay = np.zeros((HIGH, WIDE, 4))
    overlay[5:10, 5:35] = (0, 1, 0, 1)
    overlay[20:25, 5:35] = (0, 1, 0, 0.5)
    if as_bytes:
        overlay = np.rint(overlay * 255).astype(np.uint8)
    shown = View(Pose((0.1, 0, 0)), HERE.fov)
    bare = warp_image(*picture, HERE, shown, gpu=gpu).colour
    out = warp_image(*picture, HERE, shown, effects="overlay", layers={"overlay": overlay}, gpu=gpu).colour
    assert np.allclose(out[5:10, 5:35], (0, 1, 0), atol=1e-3)
    assert np.array_equal(out[12:18], bare[12:18])
    # Half of each, to the step of a byte and of a half float.
    assert np.allclose(out[20:25, 5:35], 0.5 * bare[20:25, 5:35] + (0, 0.5, 0), atol=0.005)


@pytest.mark.parametrize(
    ("effects", "layers", "told"),
    [
        ("soft_motion", {}, "warp 'iterative' with effect 'soft_motion' reads layer 'velocity': give layers"),
        ("overlay", {}, "reads layer 'overlay': give layers={'overlay': ..}, .h, w, 4. of the result's size"),
        ("none", {"velocity": 0}, "layer 'velocity': warp 'iterative' does not read it"),
        ("none", {"normals": 0}, "layer 'normals' is unknown: expected velocity, ids, overlay"),
        ("none", {"cube": 0}, "layer 'cube' .colour of everything.* comes from a server or the feed alone: expected"),
        ("overlay", {"overlay": np.zeros((3, 3, 4))}, "layer 'overlay' is float64 .3, 3, 4.: expected numbers"),
        ("overlay", {"overlay": np.full((HIGH, WIDE, 4), 2.0)}, "alpha of layer 'overlay' is 2 to 2: expected 0 to 1"),
        ("soft_motion", {"velocity": np.full((HIGH, WIDE, 3), np.nan)}, "layer 'velocity' has NaN"),
        ("rigid_motion", {"ids": np.zeros((HIGH, WIDE))}, "layer 'ids' is a ndarray: expected .numbers, bodies."),
        ("rigid_motion", {"ids": (np.ones((HIGH, WIDE), int), [])}, "numbers of 0 to 0, as there are 0 bodies"),
        ("rigid_motion", {"ids": (np.zeros((HIGH, WIDE), int), [1])}, "expected a hmdwarp.geometry.RigidState"),
        ("rigid_motion", {"ids": (np.zeros((HIGH, WIDE), int), [BODY] * 65536)}, "65536 bodies: expected 65535"),
    ],
)
def test_a_layer_that_is_missing_or_wrong_is_named(picture, gpu, effects, layers, told):
    with pytest.raises(InputError, match=told):
        warp_image(*picture, HERE, HERE, effects=effects, layers=layers, gpu=gpu)


def test_layers_come_as_arrays_and_effects_of_a_scene_stay_refused(picture, gpu):
    with Warper(SIZE, effects="overlay", gpu=gpu) as warper, pytest.raises(InputError, match="runs on arrays"):
        pair = allocate(gpu.gl, SIZE, COLOUR), allocate(gpu.gl, SIZE, SCALAR)
        warper.warp_textures(*pair, HERE, HERE)
    with pytest.raises(PlanError, match="layer .light. from the server .* the scene.s geometry on the client"):
        warp_image(*picture, HERE, HERE, effects="light_only", gpu=gpu)
    with pytest.raises(InputError, match="age_s is inf"):
        warp_image(*picture, HERE, HERE, age_s=np.inf, gpu=gpu)
