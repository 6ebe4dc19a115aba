"""The order from the epipole: what it guarantees, on which rays, and where pixels are not rays."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from worlds import World

from hmdwarp.geometry import Pose, View

from .scatters import Scatter

SHEETS = ["forward_ordered:sheets=rings", "forward_ordered:sheets=rows"]
RIGHT, UP, AHEAD = np.array([1.0, 0, 0]), np.array([0, 1.0, 0]), np.array([0, 0, -1.0])


def both(gpu, step: np.ndarray, depth: np.ndarray, spec: str) -> tuple[np.ndarray, np.ndarray]:
    """Winners by the order and by the depth test."""
    size = depth.shape[::-1]
    return tuple(Scatter(gpu, size, size, shown_pose=Pose(step), spec=each).run(depth) for each in (spec, "forward"))


def boxes(seed: int, size: tuple[int, int], count: int = 12) -> np.ndarray:
    """Upright rectangles at 0.7 m to 10 m before a wall, some leaning."""
    rng, (wide, high) = np.random.default_rng(seed), size
    depth, (y, x) = np.full((high, wide), 0.1), np.mgrid[:high, :wide]
    for _ in range(count):
        cx, cy, near = rng.uniform(0, wide), rng.uniform(0, high), rng.uniform(0.1, 1.4)
        inside = (abs(x - cx) < rng.uniform(2, 0.2 * wide)) & (abs(y - cy) < rng.uniform(2, 0.2 * high))
        plane = near + rng.normal(scale=0.1 / wide) * (x - cx) + rng.normal(scale=0.1 / wide) * (y - cy)
        depth = np.where(inside & (plane > depth), plane, depth)
    return depth


@pytest.mark.parametrize("spec", SHEETS)
@pytest.mark.parametrize("step", [0.3 * RIGHT, -0.3 * RIGHT, 0.3 * UP, -0.3 * UP], ids=str)
@pytest.mark.parametrize("seed", range(2))
def test_sideways_it_equals_the_depth_test_whatever_the_scene(gpu, spec, step, seed):
    """Rows (or columns) are epipolar lines then.

    Of two pixels of one line that land in one, the one nearer the epipole has moved farther, so it
    is nearer: they were a pixel or more apart before and are less than one apart now. No scene
    breaks that.
    """
    rng = np.random.default_rng(seed)
    for depth in (boxes(seed, (61, 47)), rng.uniform(0, 1.5, (47, 61)), rng.choice([-1.0, 0, 0.3, 1], (47, 61))):
        ordered, nearest = both(gpu, step, depth, spec)
        assert np.array_equal(ordered, nearest)


@pytest.mark.parametrize("spec", SHEETS)
@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("where", ["inside", "centre", "behind", "infinite", "none", "outside", "corner"])
def test_wherever_the_epipole_lies_the_painted_twin_agrees(gpu, spec, seed, where):
    world = World(gpu, seed, (67, 53), (70, 50))
    rendered, rng = world.rendered_view, np.random.default_rng(seed)
    left, right, down, up = rendered.fov.tangents
    half_pixel = np.array([right - left, up - down]) / np.array(world.size)
    tangent = {
        "inside": (left + rng.uniform() * (right - left), down + rng.uniform() * (up - down)),
        "centre": (left + 20.5 * half_pixel[0], down + 30.5 * half_pixel[1]),
        "behind": (left + rng.uniform() * (right - left), down + rng.uniform() * (up - down)),
        "infinite": tuple(rng.normal(size=2)),
        "none": (0, 0),
        "outside": tuple(rng.normal(scale=20, size=2)),
        "corner": (left, down),
    }[where]
    along = {"behind": 1.0, "infinite": 0.0, "none": 0.0}.get(where, -1.0)
    step = np.array([-along * tangent[0], -along * tangent[1], along]) if along else np.array([*tangent, 0.0])
    step *= 0.05 / max(np.linalg.norm(step), 1)
    turn = Rotation.from_rotvec(np.deg2rad(rng.normal(scale=3, size=3)))
    pose = Pose(
        rendered.pose.position_m + rendered.pose.rotation.apply(step), (rendered.pose.rotation * turn).as_quat()
    )
    world.shown_view = View(pose, rendered.fov)
    got, wanted = world.warp(gpu, spec), world.reference(spec)
    assert np.isfinite(got).all()
    decided = ~wanted.undecided
    assert decided.mean() > 0.9
    assert np.array_equal(got[decided], wanted.colour[decided])


@pytest.mark.parametrize("spec", SHEETS)
@pytest.mark.parametrize("size", [(1, 1), (1, 9), (130, 1), (64, 64), (67, 53)], ids=str)
@pytest.mark.parametrize("step", [0 * AHEAD, 1e-12 * AHEAD, 1e-12 * RIGHT, -1e-12 * AHEAD + 1e-13 * UP], ids=str)
def test_every_pixel_has_its_own_place_in_the_order(gpu, spec, size, step):
    """Motion that moves nothing. All pixels arrive, each as itself, so that its place was told back
    as it was given."""
    depth = np.random.default_rng(0).uniform(0, 2, size[::-1])
    got = Scatter(gpu, size, size, shown_pose=Pose(step), spec=spec).run(depth)
    assert np.array_equal(got.ravel(), np.arange(size[0] * size[1]))
