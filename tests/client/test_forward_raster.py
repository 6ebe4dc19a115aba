"""Without a depth test: the later one in raster order stays, whatever hides whom."""

from __future__ import annotations

import numpy as np
import pytest

from hmdwarp.geometry import Pose

from .scatters import Scatter


def painted(scatter: Scatter, depth: np.ndarray, step: int) -> np.ndarray:
    """One pixel after the other in raster order, each `step` pixels per 1/m to the left."""
    wide, high = scatter.size
    out = np.full((high, wide), -1)
    for y in reversed(range(high)):
        for x in range(wide):
            to = x - round(step * depth[y, x])
            if depth[y, x] >= 0 and 0 <= to < wide:
                out[y, to] = y * wide + x
    return out


@pytest.mark.parametrize("seed", range(3))
def test_a_loop_over_the_pixels_gives_the_same(gpu, seed):
    """0.5 m to the right at 32 pixels per tangent: 16 px of parallax at 1 m.

    Depths in eighths land on whole pixels.
    """
    scatter = Scatter(gpu, (64, 48), (64, 48), shown_pose=Pose((0.5, 0, 0)), spec="forward_raster")
    depth = np.random.default_rng(seed).choice([-1.0, 0, 0.125, 0.5, 1], (48, 64))
    assert np.array_equal(scatter.run(depth), painted(scatter, depth, 16))


@pytest.mark.parametrize("seed", range(3))
def test_more_pictures_after_one_another_do_not_remember_each_other(gpu, seed):
    scatter = Scatter(gpu, (31, 17), (31, 17), spec="forward_raster")
    index = np.arange(31 * 17).reshape(17, 31)
    for share in (0.0, 0.9, 0.3, 1.0):
        holes = np.random.default_rng(seed).uniform(size=(17, 31)) < share
        assert np.array_equal(scatter.run(np.where(holes, -1, 0.5)), np.where(holes, -1, index))
