"""Iterative.

Converges on the surface in front, leaves holes where no surface was seen, and equals its twin with
every setting.
"""

from __future__ import annotations

import numpy as np
import pytest
from reference.iterative import iterative
from worlds import World

from hmdwarp.geometry import Pose

from .rendered_pictures import asked, square_before_a_wall, warped

SPECS = [
    "iterative",
    "iterative:slanted=3",
    "iterative:seed=rotation,steps=5",
    "iterative:steps=1,tolerance=0.1,converged=2",
]
# A bilinear look off by the sampler's 1/256 px in a ramp of 1/60 a pixel, and a half float stored.
RAMP = 1 / 60 / 256 + 2.0**-10


@pytest.mark.parametrize("spec", SPECS)
@pytest.mark.parametrize("seed", range(30, 34))
def test_every_setting_equals_the_twin(gpu, spec, seed):
    size = [(67, 53), (64, 64)][seed % 2]
    world = World(gpu, seed, size)
    got, wanted = world.warp(gpu, spec), world.reference(spec)
    decided = ~wanted.undecided
    assert decided.mean() > 0.95
    assert np.array_equal(got[..., 3][decided], wanted.colour[..., 3][decided])
    assert (np.abs(got[..., :3] - wanted.colour[..., :3]).max(axis=-1) <= wanted.tolerance)[decided].all()


@pytest.mark.parametrize("spec", ["iterative", "iterative:steps=1", "iterative:seed=rotation,steps=1,converged=20"])
def test_one_look_is_exact_on_a_slanted_plane(gpu, spec):
    """Inverse depth 0.5 + 0.2 x at the tangent x, seen from 0.2 m to the right.

    x_shown = x - 0.2 (0.5 + 0.2 x) of the tangent.
    """
    x = (np.arange(60) + 0.5) / 30 - 1
    depth = np.tile(0.5 + 0.2 * x, (60, 1))
    colour = np.stack([np.tile(x + 1, (60, 1)), depth, np.zeros((60, 60)), np.ones((60, 60))], axis=-1)
    got = warped(gpu, spec, colour, depth, Pose((0.2, 0, 0)))
    from_x = (x + 0.1) / (1 - 0.04)
    inside = np.abs(from_x) < 1 - 1 / 60  # further out the rendered ramp ends half a pixel before the border
    assert (got[:, np.abs(from_x) < 1, 3] == 1).all()
    assert np.abs(got[..., 0] - (from_x + 1))[:, inside].max() <= 2 * (1 / 30 / 256 + 2.0**-10)


@pytest.mark.parametrize("spec", ["iterative:fringe=own", "iterative:fringe=own,slanted=3"])
def test_a_near_thing_leaves_a_hole_of_its_parallax(gpu, spec):
    """Seen from 0.4 m to the right at 30 pixels per tangent.

    12 px of parallax at 1 m, 3 px at 4 m.
    """
    colour, depth = square_before_a_wall(np.s_[20:40, 20:40])
    got = warped(gpu, spec, colour, depth, Pose((0.4, 0, 0)))
    y, x = np.mgrid[:60, :60]
    thing, hole = ((y >= 20) & (y < 40) & (x >= a) & (x < b) for a, b in ((8, 28), (28, 37)))
    assert np.array_equal(got[..., 3] == 0, hole | (x >= 57))
    seen = got[..., 3] == 1
    assert np.abs(got[..., 0] - np.where(thing, 1.0, 0.25))[seen].max() <= 2.0**-10  # no colour crosses a silhouette
    assert np.abs(got[..., 1] - np.where(thing, x + 12, x + 3) / 60)[seen].max() <= RAMP


def antialiased_thing(left: float, right: float) -> np.ndarray:
    """(60, 60, 4): white from left to right before 0.2; each pixel is the mean of its area."""
    x = np.arange(60)
    share = np.clip(np.minimum(x + 1, right) - np.maximum(x, left), 0, 1)
    return np.tile(np.append(np.repeat(0.2 + 0.8 * share[:, None], 3, axis=1), np.ones((60, 1)), axis=1), (60, 1, 1))


def test_mixed_pixels_move_with_the_thing_in_front(gpu):
    """Its sides lie at 20.4 and 40.3, so pixels 20 and 40 are mixed; the latter's centre is wall.

    Moved by 12 pixels, and the wall by 3: at 43 - 3 = 37 such a pixel of the wall would be seen.
    """
    colour, depth = antialiased_thing(20.4, 40.3), square_before_a_wall(np.s_[:, 20:40])[1]
    truth = antialiased_thing(20.4 - 12, 40.3 - 12)
    now, before = (
        warped(gpu, spec, colour, depth, Pose((0.4, 0, 0))) for spec in ("iterative", "iterative:fringe=own")
    )
    seen = now[..., 3] == 1
    assert seen[:, 7:29].all()
    assert np.abs(now - truth)[seen].max() <= 2.0**-9
    assert before[0, 28, 3] == 0
    assert np.abs(before[:, 37, 0] - colour[0, 40, 0]).max() <= 2.0**-9  # a ghost on the wall


def test_a_silhouette_moves_smoothly_where_surfaces_part_by_less_than_a_pixel(gpu):
    """Each step moves the thing by 0.03 pixels, so 0.024 of the contrast of 0.8, and a sheet of 0.7
    pixels stretches that by less than 1.5. Without a sheet a mixed pixel of 0.3 leaps at once.
    """
    colour, depth = antialiased_thing(20.4, 40.3), square_before_a_wall(np.s_[:, 20:40])[1]

    def largest_step(spec: str) -> float:
        moved = [warped(gpu, spec, colour, depth, Pose((x, 0, 0)))[30, 15:45] for x in np.arange(0, 0.03, 0.001)]
        return np.abs(np.diff(moved, axis=0)).max()

    assert largest_step("iterative") < 1.5 * 0.024
    assert largest_step("iterative:sheet=0") > 0.2


def test_a_thin_near_thing_is_found_by_the_forward_seed_alone(gpu):
    """Two pixels wide, moved by 12.

    From infinity the guess lands on the wall beside it and stays there.
    """
    colour, depth = square_before_a_wall(np.s_[:, 30:32])
    there = {
        spec: warped(gpu, spec, colour, depth, Pose((0.4, 0, 0)))[..., 0] > 0.99
        for spec in ("iterative", "iterative:seed=rotation")
    }
    assert there["iterative"][:, 18:20].all()
    assert there["iterative"].sum() == 2 * 60
    assert not there["iterative:seed=rotation"].any()


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, -1.0, -1e-40])
def test_no_depth_stays_a_hole_and_does_not_spread(gpu, bad):
    colour, depth = np.full((24, 24, 4), 0.5), np.full((24, 24), 0.5)
    colour[..., 3] = 1
    colour[10:13, 10:13], depth[10:13, 10:13] = 0, bad
    got = warped(gpu, "iterative", colour, depth, Pose((0.1, 0.05, 0)))  # 0.6 and 0.3 px
    assert np.isfinite(got).all()
    assert np.isin(got[..., :3], (0, 0.5)).all()
    assert 4 <= (got[1:-1, 1:-1, 3] == 0).sum() <= 16


def test_sky_is_seen_and_does_not_move(gpu):
    colour, depth = square_before_a_wall(np.s_[20:40, 20:40])
    sky = np.where(depth == 1, 1.0, 0.0)
    got = warped(gpu, "iterative", colour, sky, Pose((0.4, 0.1, 0)))
    assert (got[50:, :, 3] == 1).all()
    assert np.abs(got[50:, :, 1:3] - colour[50:, :, 1:3]).max() <= RAMP


@pytest.mark.parametrize("pose", [Pose((0, 0, -3.0)), Pose((0, 0, 0), (0, 1, 0, 0)), Pose((0, 0, -3.0), (0, 1, 0, 0))])
def test_a_surface_behind_an_eye_is_not_mirrored(gpu, pose):
    """Past a wall at 2 m, and turned round.

    The rendered picture shows nothing of what is before the eye.
    """
    got = warped(gpu, "iterative", np.ones((21, 21, 4)), np.full((21, 21), 0.5), pose)
    assert (got == 0).all()


@pytest.mark.parametrize("step_m", [1e-9, 1e-6])
def test_a_tiny_motion_leaves_no_hole(gpu, step_m):
    rng = np.random.default_rng(4)
    colour, depth = np.ones((40, 40, 4)), rng.choice([0.0, 0.3, 2.0, 1000.0], (40, 40))
    colour[..., :3] = rng.uniform(0, 2, (40, 40, 3))
    got = warped(gpu, "iterative", colour, depth, Pose((-step_m, -step_m, step_m)))
    assert (got[1:-1, 1:-1, 3] == 1).all()
    # 30 px x 1000 1/m x 2e-6 m = 0.06 px at most, along each axis, of a contrast below 2.
    assert np.abs(got - colour)[1:-1, 1:-1].max() <= 2 * 2 * (30 * 1000 * 2 * step_m + 1 / 256) + 2.0**-9


def test_depths_from_a_millimetre_to_a_million_metres(gpu):
    rng = np.random.default_rng(5)
    colour, depth = np.ones((33, 29, 4)), rng.choice([1e3, 1e-6, 0.0, 3e38, 1e-40], (33, 29))
    for pose in (Pose((0.05, 0, 0)), Pose((0, 0, 0.5)), Pose((1e-4, 0, -1e-4))):
        got = warped(gpu, "iterative", colour, depth, pose)
        wanted = iterative(asked(gpu, "iterative", colour, np.where(depth < 1e30, depth, -1), pose))
        assert np.isfinite(got).all()
        decided = ~wanted.undecided
        # 3e38 is no depth for the shader, and -1 stands for it here: it is a neighbour of nothing
        # in both.
        assert np.array_equal(got[..., 3][decided], wanted.colour[..., 3][decided])
