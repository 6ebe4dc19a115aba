"""Search.

The front one of several surfaces on a ray, holes where none was seen, and the same as brute force
with every setting.
"""

from __future__ import annotations

import numpy as np
from reference.search import search
from worlds import assert_equals_twin

from hmdwarp.geometry import Pose

from .rendered_pictures import asked, square_before_a_wall, warped


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
        # A long ray comes near many corners, and one row runs along a line between quarters.
        assert_equals_twin(got, wanted, 0.6)


def test_too_few_steps_end_in_holes(gpu):
    colour, depth = square_before_a_wall(np.s_[20:40, 20:40])
    few, enough = (warped(gpu, f"search:steps={n}", colour, depth, Pose((0.4, 0, 0)))[..., 3] for n in (5, 512))
    assert few.sum() < enough.sum()
    assert (few <= enough).all()
