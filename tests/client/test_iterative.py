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
