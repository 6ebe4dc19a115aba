"""What every warp that moves pixels by their depth must do, in pictures whose result is known."""

from __future__ import annotations

import numpy as np
import pytest

from hmdwarp.geometry import Pose

from .rendered_pictures import square_before_a_wall, warped

CUTS = ["mesh", "mesh:cut=vertex", "mesh:cut=both", "mesh_adaptive"]
SEARCHING = ["search", "iterative:fringe=own", "iterative:fringe=own,slanted=3"]
# A bilinear look off by the sampler's 1/256 px in a ramp of 1/60 a pixel, and a half float stored.
RAMP = 1 / 60 / 256 + 2.0**-10


@pytest.mark.parametrize("spec", SEARCHING)
def test_a_near_thing_leaves_a_hole_of_its_parallax(gpu, spec):
    """Seen from 0.4 m to the right at 30 pixels per tangent: 12 px of parallax at 1 m, 3 at 4 m."""
    colour, depth = square_before_a_wall(np.s_[20:40, 20:40])
    got = warped(gpu, spec, colour, depth, Pose((0.4, 0, 0)))
    y, x = np.mgrid[:60, :60]
    thing, hole = ((y >= 20) & (y < 40) & (x >= a) & (x < b) for a, b in ((8, 28), (28, 37)))
    assert np.array_equal(got[..., 3] == 0, hole | (x >= 57))
    seen = got[..., 3] == 1
    assert np.abs(got[..., 0] - np.where(thing, 1.0, 0.25))[seen].max() <= 2.0**-10  # no colour crosses a silhouette
    assert np.abs(got[..., 1] - np.where(thing, x + 12, x + 3) / 60)[seen].max() <= RAMP


@pytest.mark.parametrize(
    "spec", ["search", "iterative", "iterative:steps=1", "iterative:seed=rotation,steps=1,converged=20"]
)
def test_a_slanted_plane_is_exact(gpu, spec):
    """Inverse depth 0.5 + 0.2 x at the tangent x, seen from 0.2 m to the right.

    x_shown = x - 0.2 (0.5 + 0.2 x) of the tangent.
    """
    x = (np.arange(60) + 0.5) / 30 - 1
    depth = np.tile(0.5 + 0.2 * x, (60, 1))
    colour = np.stack([np.tile(x + 1, (60, 1)), depth, np.zeros((60, 60)), np.ones((60, 60))], axis=-1)
    got = warped(gpu, spec, colour, depth, Pose((0.2, 0, 0)))
    from_x = (x + 0.1) / (1 - 0.04)
    assert (got[:, np.abs(from_x) < 1, 3] == 1).all()
    inside = np.abs(from_x) < 1 - 1 / 60  # further out the rendered ramp ends half a pixel before the border
    assert np.abs(got[..., 0] - (from_x + 1))[:, inside].max() <= 2 * (1 / 30 / 256 + 2.0**-10)


@pytest.mark.parametrize("spec", ["search", "iterative", *CUTS])
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, -1.0, -1e-40])
def test_no_depth_stays_a_hole_and_does_not_spread(gpu, spec, bad):
    colour, depth = np.full((24, 24, 4), 0.5), np.full((24, 24), 0.5)
    colour[..., 3] = 1
    colour[10:13, 10:13], depth[10:13, 10:13] = 0, bad
    got = warped(gpu, spec, colour, depth, Pose((0.1, 0.05, 0)))  # 0.6 and 0.3 px
    assert np.isin(got[..., :3], (0, 0.5)).all()
    assert 4 <= (got[1:-1, 1:-1, 3] == 0).sum() <= 16


@pytest.mark.parametrize("spec", ["search", "iterative", *CUTS])
@pytest.mark.parametrize("pose", [Pose((0, 0, -3.0)), Pose((0, 0, 0), (0, 1, 0, 0)), Pose((0, 0, -3.0), (0, 1, 0, 0))])
def test_a_surface_behind_an_eye_is_not_mirrored(gpu, spec, pose):
    """Past a wall at 2 m, and turned round: the picture shows nothing of what is before the eye."""
    got = warped(gpu, spec, np.ones((21, 21, 4)), np.full((21, 21), 0.5), pose)
    assert (got == 0).all()


@pytest.mark.parametrize("spec", ["search", "iterative", *CUTS])
@pytest.mark.parametrize("step_m", [1e-9, 1e-6])
def test_a_tiny_motion_leaves_no_hole(gpu, spec, step_m):
    rng = np.random.default_rng(4)
    colour, depth = np.ones((40, 40, 4)), rng.choice([0.0, 0.3, 2.0, 1000.0], (40, 40))
    colour[..., :3] = rng.uniform(0, 2, (40, 40, 3))
    got = warped(gpu, spec, colour, depth, Pose((-step_m, -step_m, step_m)))
    assert (got[1:-1, 1:-1, 3] == 1).all()
    if spec not in CUTS:
        # 30 px x 1000 1/m x 2e-6 m = 0.06 px at most, along each axis, of a contrast below 2.
        assert np.abs(got - colour)[1:-1, 1:-1].max() <= 2 * 2 * (30 * 1000 * 2 * step_m + 1 / 256) + 2.0**-9
