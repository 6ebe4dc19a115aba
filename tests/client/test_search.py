"""Search.

The front one of several surfaces on a ray, holes where none was seen, and the same as brute force
with every setting.
"""

from __future__ import annotations

import numpy as np
import pytest
from reference.search import search
from worlds import World

from hmdwarp.geometry import Pose

from .rendered_pictures import asked, square_before_a_wall, warped


@pytest.mark.parametrize("spec", ["search", "search:gap=0.5,tolerance=0.1"])
@pytest.mark.parametrize("seed", range(40, 43))
def test_every_setting_equals_brute_force(gpu, spec, seed):
    world = World(gpu, seed, [(67, 53), (64, 64)][seed % 2])
    got, wanted = world.warp(gpu, spec), world.reference(spec)
    decided = ~wanted.undecided
    assert decided.mean() > 0.9
    assert np.array_equal(got[..., 3][decided], wanted.colour[..., 3][decided])
    assert (np.abs(got[..., :3] - wanted.colour[..., :3]).max(axis=-1) <= wanted.tolerance)[decided].all()


def test_a_large_motion_through_many_levels_equals_brute_force(gpu):
    """Segments of up to a hundred pixels past a comb of posts.

    Blocks are skipped on all levels of the pyramid.
    """
    rng = np.random.default_rng(9)
    depth = np.full((11, 301), 0.2)
    depth[:, 40:280:37] = 1.0
    depth[:, 60:280:71] = 0.6
    colour = np.concatenate([rng.uniform(0, 1, (11, 301, 3)), np.ones((11, 301, 1))], axis=-1)
    for pose in (Pose((0.6, 0.01, 0)), Pose((0.3, 0, -0.3), (0, 0.1, 0, 1))):
        got, wanted = warped(gpu, "search", colour, depth, pose), search(asked(gpu, "search", colour, depth, pose))
        decided = ~wanted.undecided
        assert (
            decided.mean() > 0.6
        )  # a long ray comes near many corners, and one row runs along a line between quarters
        assert np.array_equal(got[..., 3][decided], wanted.colour[..., 3][decided])
        assert (np.abs(got[..., :3] - wanted.colour[..., :3]).max(axis=-1) <= wanted.tolerance)[decided].all()


@pytest.mark.parametrize("width", [1, 2, 3])
def test_the_thinnest_thing_in_front_is_found_whole_and_what_is_behind_it_too(gpu, width):
    """A post before a wall, moved by 12 px.

    Each of its columns once, the wall elsewhere, and a hole as wide as the post.
    """
    colour, depth = square_before_a_wall(np.s_[:, 30 : 30 + width])
    got = warped(gpu, "search", colour, depth, Pose((0.4, 0, 0)))
    assert np.array_equal(np.argwhere(got[7, :, 0] > 0.99)[:, 0], np.arange(18, 18 + width))
    assert np.array_equal(np.argwhere(got[7, :57, 3] == 0)[:, 0], np.arange(27, 27 + width))


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, -1.0, -1e-40])
def test_no_depth_stays_a_hole_and_does_not_spread(gpu, bad):
    colour, depth = np.full((24, 24, 4), 0.5), np.full((24, 24), 0.5)
    colour[..., 3] = 1
    colour[10:13, 10:13], depth[10:13, 10:13] = 0, bad
    got = warped(gpu, "search", colour, depth, Pose((0.1, 0.05, 0)))  # 0.6 and 0.3 px
    assert np.isin(got[..., :3], (0, 0.5)).all()
    assert 4 <= (got[1:-1, 1:-1, 3] == 0).sum() <= 16


@pytest.mark.parametrize("pose", [Pose((0, 0, -3.0)), Pose((0, 0, 0), (0, 1, 0, 0)), Pose((0, 0, -3.0), (0, 1, 0, 0))])
def test_a_surface_behind_an_eye_is_not_mirrored(gpu, pose):
    """Past a wall at 2 m, and turned round.

    The rendered picture shows nothing of what is before the eye.
    """
    assert (warped(gpu, "search", np.ones((21, 21, 4)), np.full((21, 21), 0.5), pose) == 0).all()


@pytest.mark.parametrize("step_m", [1e-9, 1e-6])
def test_a_tiny_motion_leaves_no_hole(gpu, step_m):
    rng = np.random.default_rng(4)
    colour, depth = np.ones((40, 40, 4)), rng.choice([0.0, 0.3, 2.0, 1000.0], (40, 40))
    colour[..., :3] = rng.uniform(0, 2, (40, 40, 3))
    got = warped(gpu, "search", colour, depth, Pose((-step_m, -step_m, step_m)))
    assert (got[1:-1, 1:-1, 3] == 1).all()
    # 30 px x 1000 1/m x 2e-6 m = 0.06 px at most, along each axis, of a contrast below 2.
    assert np.abs(got - colour)[1:-1, 1:-1].max() <= 2 * 2 * (30 * 1000 * 2 * step_m + 1 / 256) + 2.0**-9
