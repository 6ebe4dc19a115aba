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


def test_too_few_steps_end_in_holes(gpu):
    colour, depth = square_before_a_wall(np.s_[20:40, 20:40])
    few, enough = (warped(gpu, f"search:steps={n}", colour, depth, Pose((0.4, 0, 0)))[..., 3] for n in (5, 512))
    assert few.sum() < enough.sum()
    assert (few <= enough).all()
