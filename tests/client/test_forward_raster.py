"""Without a depth test: the later one in raster order stays, whatever hides whom."""

from __future__ import annotations

import numpy as np
import pytest
from worlds import World

from hmdwarp.client.warps import warps
from hmdwarp.errors import InputError
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


@pytest.mark.parametrize(("step", "wins"), [(0.5, "near"), (-0.5, "far")])
def test_a_later_pixel_hides_a_nearer_one(gpu, step, wins):
    """Half the picture at 1 m, half at 8 m, which come to lie over each other where the eye moves
    to the near side.
    """
    depth = np.full((8, 64), 0.125)
    near_columns = slice(32, 64) if wins == "near" else slice(0, 32)
    depth[:, near_columns] = 1.0
    got = Scatter(gpu, (64, 8), (64, 8), shown_pose=Pose((step, 0, 0)), spec="forward_raster").run(depth)
    rows, columns = np.divmod(got, 64)
    nearest = Scatter(gpu, (64, 8), (64, 8), shown_pose=Pose((step, 0, 0))).run(depth)
    differs = (got != nearest).any(axis=0)
    if wins == "near":
        assert not differs.any(), "the near half comes later anyway"
    else:
        assert differs.sum() == 14, "of 16 px of parallax against 2, all overlap"
        assert (depth[rows, columns][:, differs] == 0.125).all()


def test_the_lower_row_of_the_picture_wins(gpu):
    """Of a block that lands in one pixel the lowest row and in it the rightmost pixel.

    The last in a file.
    """
    got = Scatter(gpu, (64, 64), (8, 8), spec="forward_raster").run(np.full((64, 64), 0.5))
    y, x = np.mgrid[:8, :8] * 8
    assert np.array_equal(got, y * 64 + x + 7), "row 0 is the bottom one here"


@pytest.mark.parametrize("seed", range(3))
def test_more_pictures_after_one_another_do_not_remember_each_other(gpu, seed):
    scatter = Scatter(gpu, (31, 17), (31, 17), spec="forward_raster")
    index = np.arange(31 * 17).reshape(17, 31)
    for share in (0.0, 0.9, 0.3, 1.0):
        holes = np.random.default_rng(seed).uniform(size=(17, 31)) < share
        assert np.array_equal(scatter.run(np.where(holes, -1, 0.5)), np.where(holes, -1, index))


def test_a_depth_test_is_needed(gpu):
    """In a world of boxes many pixels show something hidden."""
    world = World(gpu, 4, (160, 120))
    raster, nearest = world.warp(gpu, "forward_raster"), world.warp(gpu, "forward")
    assert np.array_equal(raster[..., 3], nearest[..., 3]), "the same places are covered"
    assert (raster != nearest).any(axis=-1).mean() > 0.005


def test_a_picture_with_longer_sides_than_the_order_has_bits_for_is_refused(gpu):
    with pytest.raises(
        InputError, match="a rendered picture of 16385x2: 'forward_raster' takes at most 16384 pixels a side"
    ):
        warps.get("forward_raster")(gpu, (16385, 2), (8, 8))
