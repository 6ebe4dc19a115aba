"""Holes, and which of them no late frame could have filled."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hmdwarp.geometry import Pose, View
from hmdwarp.metrics import border_holes, hole_share

from .pictures import FOV, turned

SIZE = (41, 33)
EMPTY = np.zeros((33, 41), np.float32)
small = st.floats(-0.3, 0.3)
poses = st.builds(
    lambda yaw, pitch, roll, x, y, z: turned(yaw, pitch, roll, (x, y, z)), small, small, small, small, small, small
)


def border_share(*arguments) -> float:
    """Share of the picture's pixels."""
    return float(border_holes(*arguments).mean())


def test_share_counts_zeros_only():
    coverage = np.array([[0, 0.25], [1, 1e-6]])
    assert hole_share(coverage) == 0.25
    assert hole_share(coverage > 0) == 0.25


@settings(max_examples=60)
@given(poses, st.integers(0, 2**32 - 1))
def test_border_against_rays(shown, seed):
    """The other route: points in the world and four planes.

    A point within 1e-9 of a plane may fall either way; none does.
    """
    rng = np.random.default_rng(seed)
    depth_m = rng.uniform(0.4, 20, (33, 41))
    coverage = rng.random((33, 41)) > 0.5
    rendered = View(Pose(), FOV)
    # Whether each pixel's surface point lies outside `rendered`, through points in the world.
    points = shown.rays(SIZE) * depth_m[::-1][..., None]
    x, y, z = np.moveaxis(rendered.pose.inverse().transform(shown.pose.transform(points)), -1, 0)
    left, right, down, up = rendered.fov.tangents
    inside = (z < 0) & (x >= -left * z) & (x <= -right * z) & (y >= -down * z) & (y <= -up * z)
    expected = ((~inside[::-1]) & ~coverage).sum() / coverage.size
    assert border_share(coverage, 1 / depth_m, shown, rendered, (64, 50)) == pytest.approx(expected, abs=1e-12)


def test_behind_the_late_eye_is_outside():
    about = turned(math.pi)
    assert border_share(EMPTY, EMPTY, about, turned(0), SIZE) == 1
    # A step back of 2 m: what is 1 m before the present eye lay 1 m behind the late one.
    back = turned(0, position_m=(0, 0, 2))
    assert border_share(EMPTY, EMPTY + 1, back, turned(0), SIZE) == 1
    assert border_share(EMPTY, EMPTY, back, turned(0), SIZE) == 0


def test_a_missing_depth_counts_as_infinitely_far():
    shown, nothing = turned(-0.3), np.full_like(EMPTY, np.nan)
    far = border_share(EMPTY, EMPTY, shown, turned(0), SIZE)
    assert border_share(EMPTY, nothing, shown, turned(0), SIZE) == far > 0
