"""Layers that a caller gives beside colour and depth: each does what its effect says."""

from __future__ import annotations

import numpy as np
import pytest

from hmdwarp import Fov, InputError, Pose, View, Warper, warp_image
from hmdwarp.client import Compensator, PassInputs
from hmdwarp.errors import PlanError
from hmdwarp.frames.layers.pictures import Reflection
from hmdwarp.geometry import Mirror, RigidState
from hmdwarp.gpu import COLOUR, SCALAR, allocate, download
from hmdwarp.scenes import load_scene
from hmdwarp.sources.server import Server

SIZE = WIDE, HIGH = 40, 30
FAR_M, NEAR_M = 8.0, 2.0
# 20 pixels per tangent: 0.2 m at 2 m are 2 pixels.
HERE = View(Pose(), Fov.from_tangents((-1.0, 1.0, -0.75, 0.75)))
PATCH = slice(10, 20)
RED, BLUE = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
MIRRORS = "planar_reflections,curved_reflections"
MIRRORED = (
    np.zeros((HIGH, WIDE, 3)),
    np.full((HIGH, WIDE), FAR_M),
    np.zeros((HIGH, WIDE, 3)),
    (Mirror((0, 0, -FAR_M), (1, 0, 0), (0, 1, 0)),),
)
BODY = RigidState(Pose())


def glass(light: float = 0.0, depth_m: float = 1.0, passing: float = 0.5) -> tuple[np.ndarray, ...]:
    """Layer 'transparent' of one pane over the whole picture."""
    return np.full((HIGH, WIDE, 3), light), np.full((HIGH, WIDE), depth_m), np.full((HIGH, WIDE, 3), passing)


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


def test_surfaces_behind_the_picture_close_its_holes(picture, gpu):
    shown = View(Pose((0.4, 0, 0)), HERE.fov)
    holes = warp_image(*picture, HERE, shown, "iterative", "none", gpu=gpu)
    wall = np.full((HIGH, WIDE, 3), BLUE)
    nothing = np.zeros((HIGH, WIDE))
    with Warper(SIZE, warp="layered", fill="none", gpu=gpu) as warper:
        amount = warper.plan.needs["peeled"]
        behind = [(wall, np.full((HIGH, WIDE), FAR_M)), *[(wall, nothing)] * (amount - 1)]
        out = warper.warp(*picture, HERE, shown, layers={"peeled": behind})
    beside = slice(8, 20)  # where the strip hid the wall
    assert (holes.coverage[HIGH // 2, beside] == 0).any()
    assert (out.coverage[HIGH // 2, beside] == 1).all()


@pytest.mark.parametrize("way_m", [(0.3, 0.0), (-0.17, 0.05), (0.0, -0.23), (0.111, 0.2)])
def test_a_hidden_layer_does_not_show_where_a_wall_leaves_the_picture(gpu, way_m):
    """The wall goes on beyond the border, so nothing of the layer behind it is ever seen."""
    wall, behind = np.full((HIGH, WIDE, 3), RED), np.full((HIGH, WIDE, 3), BLUE)
    x, y = np.meshgrid(np.arange(WIDE), np.arange(HIGH))
    depth = 2.0 + 0.013 * x + 0.02 * y  # slanted: half a texel lands elsewhere
    nothing = (behind, np.zeros((HIGH, WIDE)))
    with Warper(SIZE, warp="layered", fill="none", gpu=gpu) as warper:
        peeled = [(behind, np.full((HIGH, WIDE), np.inf)), *[nothing] * (warper.plan.needs["peeled"] - 1)]
        shown = View(Pose((*way_m, 0.0)), HERE.fov)
        out = warper.warp(wall, depth, HERE, shown, layers={"peeled": peeled})
    assert (out.coverage == 0).any() and out.colour[..., 2].max() == 0


def test_glass_adds_its_light_and_lets_some_through(picture, gpu):
    light, depth, passing = glass(light=0.25)
    depth[:, 30:] = 0
    given = {"transparent": (light, depth, passing)}
    out = warp_image(*picture, HERE, HERE, effects="transparency", layers=given, gpu=gpu).colour
    assert np.allclose(out[:, 1:29], 0.5 * picture[0][:, 1:29] + 0.25, atol=2e-3)
    assert np.allclose(out[:, 31:], picture[0][:, 31:], atol=2e-3)


def metres(texture) -> np.ndarray:
    """Depth as callers have it: infinity for the sky, 0 for none."""
    inverse = download(texture).astype(np.float64)
    with np.errstate(divide="ignore"):
        return np.where(inverse < 0, 0, 1 / np.abs(inverse))


def test_mirrors_show_what_the_offline_pipeline_shows_bit_for_bit(gpu):
    """One frame of a scene with mirrors, as the server drew it and through arrays of its layers."""
    size, fov = (120, 100), Fov.symmetric(1.4, 1.2)
    late, now = (View(Pose((x, 1.6, 0.0)), fov) for x in (0.0, 0.06))
    with Warper(size, effects=MIRRORS, fill="none", gpu=gpu) as warper:
        server = Server(gpu, load_scene("gallery"))
        (eye,) = server.draw_frame([late], 0, size, needs=warper.plan.needs).eyes
        compensator = Compensator(gpu, warper.plan, None, size, size)
        expected = download(compensator.run(PassInputs(eye, now, 0, shown_ns=10**8)).shown.texture)
        seen: Reflection = eye["reflection"]
        surface = download(seen.surface).astype(np.float32)
        colours = [download(texture).astype(np.float32) for texture in (eye.colour, seen.seen.colour)]
        mirrored = (colours[1], metres(seen.seen.inverse_depth), surface[..., :3], seen.mirrors)
        bare = warper.warp(colours[0], metres(eye.inverse_depth), late, now, layers={"reflection": nothing(mirrored)})
        out = warper.warp(colours[0], metres(eye.inverse_depth), late, now, layers={"reflection": mirrored})
        compensator.close()
        server.close()
    assert (surface[..., 0] > 0).mean() > 0.01 and np.abs(out.colour - bare.colour).max() > 0.01
    assert np.array_equal(out.colour, expected[..., :3] * (expected[..., 3:] > 0))


def nothing(mirrored):
    """The same frame if nothing mirrored."""
    colour, depth, surface, mirrors = mirrored
    return colour, depth, np.zeros_like(surface), mirrors


@pytest.mark.parametrize(
    ("effects", "layers", "told"),
    [
        ("soft_motion", {}, "warp 'iterative' with effect 'soft_motion' reads layer 'velocity': give layers"),
        ("overlay", {}, "reads layer 'overlay': give layers={'overlay': ..}, .h, w, 4. of the result's size"),
        ("none", {"velocity": 0}, "layer 'velocity': warp 'iterative' does not read it"),
        ("none", {"normals": 0}, "layer 'normals' is unknown: expected velocity, ids, overlay"),
        ("none", {"cube": 0}, "layer 'cube' .colour of everything.* comes from a server of our own alone: expected"),
        ("overlay", {"overlay": np.zeros((3, 3, 4))}, "layer 'overlay' is float64 .3, 3, 4.: expected numbers"),
        ("overlay", {"overlay": np.full((HIGH, WIDE, 4), 2.0)}, "alpha of layer 'overlay' is 2 to 2: expected 0 to 1"),
        ("soft_motion", {"velocity": np.full((HIGH, WIDE, 3), np.nan)}, "layer 'velocity' has NaN"),
        ("rigid_motion", {"ids": np.zeros((HIGH, WIDE))}, "layer 'ids' is a ndarray: expected .numbers, bodies."),
        ("rigid_motion", {"ids": (np.ones((HIGH, WIDE), int), [])}, "numbers of 0 to 0, as there are 0 bodies"),
        ("rigid_motion", {"ids": (np.zeros((HIGH, WIDE), int), [1])}, "expected a hmdwarp.geometry.RigidState"),
        ("rigid_motion", {"ids": (np.zeros((HIGH, WIDE), int), [BODY] * 65536)}, "65536 bodies: expected 65535"),
        ("transparency", {"transparent": glass(passing=1.5)}, "passing of layer 'transparent' is 1.5 to 1.5: expected"),
        ("transparency", {"transparent": glass(light=-1)}, "light of layer 'transparent' is -1 at least, depth_m 1: "),
        ("transparency", {"transparent": glass(depth_m=-2)}, "is 0 at least, depth_m -2: expected none below 0"),
        ("transparency", {"transparent": (0, 0)}, "layer 'transparent' is a tuple: expected .light, depth_m, passing."),
        (MIRRORS, {}, "reads layer 'reflection': give layers={'reflection': ..}, .colour, depth_m, surface, mirrors."),
        (MIRRORS, {"reflection": (*MIRRORED[:3], ())}, "mirrors of layer 'reflection': expected one .*Mirror or more"),
        (MIRRORS, {"reflection": (*MIRRORED[:3], (Mirror((0, 0, 0)),))}, "a mirror without an area"),
        (MIRRORS, {"reflection": (*MIRRORED[:2], MIRRORED[2] + 2, MIRRORED[3])}, "reflectivity .* expected 0 to 1"),
        (MIRRORS, {"reflection": (*(a[1:] for a in MIRRORED[:2]), *MIRRORED[2:])}, "mirrors is 40x29 pixels"),
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
