"""Every warp on random extreme worlds: all scales of motion, turns, depths and fields of view."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from properties import ONE_FIXTURE_FOR_ALL
from worlds import every_compared

from hmdwarp.geometry import Fov, Pose, View

from .setting import Setting


def random_depths(rng: np.random.Generator, count: int) -> np.ndarray:
    """1/m: 1e-7 to 1e4, infinitely far, none at all, and what is no number."""
    depth = 10 ** rng.uniform(-7, 4, count)
    kind = rng.uniform(size=count)
    for share, value in ((0.10, 0.0), (0.13, -1.0), (0.15, np.nan), (0.17, np.inf), (0.19, 1e-40), (0.20, -np.inf)):
        depth = np.where((kind < share) & (kind >= share - 0.03), value, depth)
    return depth


EXTREME = st.sampled_from([0.0, 1e-9, 1e-3, 0.05, 1.0, 30.0])


def random_world(
    gpu, seed: int, step: tuple, turn: float, nearest: float, sides: tuple, size: tuple[int, int]
) -> Setting:
    """step: metres on each axis, turn: the most of the quaternion's three, both with random signs.
    nearest: 1/m, what depths are cut off at, mostly; sides: degrees of the field of view."""
    rng = np.random.default_rng(seed)
    depth = np.abs(random_depths(rng, size[0] * size[1]).reshape(size[::-1]))
    depth = np.where(depth > 1e-4, np.minimum(depth, 1.0) * nearest, depth) if rng.uniform() < 0.7 else depth
    left, right, down, up = np.deg2rad(sides)
    fov = Fov(-left, right, -down, up)
    sign = rng.choice([-1, 1], 6)
    rendered = View(Pose(rng.normal(size=3), rng.normal(size=4)), fov)
    shown = View(rendered.pose @ Pose(sign[:3] * step, (*(sign[3:] * turn * rng.uniform(0, 1, 3)), 1)), fov)
    return Setting(gpu, depth, shown, rendered=rendered)


# Defaults, variants and baselines; of the other words mesh:cut=vertex still has a pixel in one of
# 200 such worlds that its twin does not mark as undecided though rounding decides it. The hard
# cases and the contract hold for it.
@pytest.mark.parametrize("name", every_compared())
@settings(max_examples=12, suppress_health_check=ONE_FIXTURE_FOR_ALL)
@given(
    seed=st.integers(0, 2**32 - 1),
    step=st.tuples(EXTREME, EXTREME, EXTREME),
    turn=EXTREME,
    nearest=st.sampled_from([1e-6, 0.3, 2.0, 1e3]),
    sides=st.tuples(st.integers(10, 85), st.integers(10, 85), st.integers(10, 85), st.integers(10, 85)),
    size=st.sampled_from([(23, 17), (8, 31), (1, 5)]),
)
def test_every_warp_on_random_extreme_worlds(gpu, name, seed, step, turn, nearest, sides, size):
    """What Setting.pictures checks. Finite, coverage 0 or 1 and right where decided, colours within
    the bound and within what went in."""
    for picture in random_world(gpu, seed, step, turn, nearest, sides, size).pictures(name):
        assert picture.colour.shape[:2] == size[::-1]


# Worlds that a warp or its twin once failed on, as above: surfaces nearer than the depth buffer
# knows (31), slivers (239) and folded pieces (the last), seams at a seventeenth of the size (174),
# a triangle edge on (692), a row between quarters (55), seeds behind the rendered eye (500216), and
# a large cell beside what is turned away (900612).
FAILED_ONCE = [
    (16, (1.0, 0.0, 0.0), 0.001, 2.0, (28, 11, 36, 40), (23, 17)),
    (31, (0.0, 0.0, 0.0), 0.001, 1000.0, (76, 43, 60, 61), (8, 31)),
    (55, (1.0, 1e-09, 0.0), 1e-09, 1000.0, (28, 53, 14, 53), (23, 17)),
    (174, (0.0, 0.001, 1.0), 30.0, 1000.0, (25, 70, 66, 45), (8, 31)),
    (239, (1.0, 0.001, 1e-09), 0.0, 2.0, (58, 66, 15, 55), (23, 17)),
    (692, (1e-09, 0.0, 0.001), 0.05, 1000.0, (38, 10, 21, 15), (8, 31)),
    (500216, (0.0, 0.001, 1e-09), 1.0, 0.3, (70, 30, 50, 39), (8, 31)),
    (900612, (1e-09, 0.05, 1.0), 0.001, 0.3, (27, 24, 21, 67), (23, 17)),
    (1404217271, (1.0, 0.0, 0.0), 0.05, 2.0, (69, 19, 48, 84), (23, 17)),
]


@pytest.mark.parametrize("name", ["iterative", "mesh", "mesh_adaptive", "mesh_adaptive:tolerance=0"])
def test_worlds_that_failed_once(gpu, name):
    for drawn in FAILED_ONCE:
        assert list(random_world(gpu, *drawn).pictures(name))
