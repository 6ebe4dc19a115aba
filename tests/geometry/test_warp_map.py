"""The warp map against another route: pixel, ray, point in the world, other eye, pixel. And what it
promises to keep."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from strategies import FOVS, neighbouring_views, poses, vectors

from hmdwarp.geometry import Fov, Pose, View, WarpMap

UNIT = 2.0**-53
SMALL_SIZES = st.tuples(st.integers(1, 2048), st.integers(1, 2048))
INVERSE_DEPTHS = st.one_of(st.sampled_from([0.0, 1e-9, 1e-3, 1.0]), st.floats(0, 3))
SHARES = st.tuples(st.floats(0, 1), st.floats(0, 1))


def long_matrix(q: np.ndarray) -> np.ndarray:
    """Rotation matrix of a quaternion in long double (64 bits of mantissa on x86)."""
    x, y, z, w = np.asarray(q, np.longdouble) / np.sqrt((np.asarray(q, np.longdouble) ** 2).sum())
    first = (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w))
    second = (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w))
    return np.array([first, second, (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y))])


def through_the_world(frm: View, frm_size, to: View, to_size, pixel, inverse_depth):
    """(pixel, inverse depth, w) in `to`, without any product of matrices. The point is scaled by
    inverse_depth, so 0 is a direction."""
    left, right, down, up = np.asarray(frm.fov.tangents, np.longdouble)
    across, along = (np.longdouble(at) / size for at, size in zip(pixel, frm_size, strict=True))
    ray = np.array([left + across * (right - left), down + along * (up - down), -1])
    apart = np.asarray(frm.pose.position_m, np.longdouble) - np.asarray(to.pose.position_m, np.longdouble)
    in_world = long_matrix(frm.pose.orientation_xyzw) @ ray + apart * inverse_depth
    x, y, z = long_matrix(to.pose.orientation_xyzw).T @ in_world
    w = -z
    left, right, down, up = np.asarray(to.fov.tangents, np.longdouble)
    landed = (x / w - left) / (right - left) * to_size[0], (y / w - down) / (up - down) * to_size[1]
    return np.array(landed), inverse_depth / w, w


def size_of_terms(frm: View, frm_size, to: View, to_size, pixel, inverse_depth) -> np.ndarray:
    """(3,) sum of the absolute terms of the map at a pixel, as it is built. What one rounding unit
    is relative to."""
    k_to, k_frm = np.abs(to.fov.pixel_from_tangent(to_size)), frm.fov.pixel_from_tangent(frm_size)
    inverse_k = np.abs(np.linalg.inv(k_frm))
    relative = frm.pose.relative_to(to.pose)
    p = np.array([*np.abs(pixel), 1.0])
    tangent = inverse_k @ np.abs(k_frm) @ inverse_k @ p
    moved = np.abs(relative.position_m) * inverse_depth
    return k_to @ (np.full((3, 3), 1.0) @ tangent + moved + moved.max())


def tolerances(terms: np.ndarray, position, w: float) -> tuple[float, float]:
    """Pixels, and relative in w. Three products of 3x3 matrices, an inverse, a rotation from a
    quaternion and a division: 64 units."""
    error = 64 * UNIT * terms
    return float(((error[:2] + np.abs(position) * error[2]) / w).max()), float(error[2] / w)


@given(neighbouring_views(), SMALL_SIZES, SMALL_SIZES, SHARES, INVERSE_DEPTHS)
def test_the_map_is_the_way_through_the_world(views, frm_size, to_size, share, inverse_depth):
    frm, to = views
    pixel = np.array(share) * frm_size
    wanted, wanted_depth, wanted_w = through_the_world(frm, frm_size, to, to_size, pixel, inverse_depth)
    got, got_depth, w = WarpMap.between(frm, frm_size, to, to_size).apply(pixel, inverse_depth)
    terms = size_of_terms(frm, frm_size, to, to_size, pixel, inverse_depth)
    assert abs(w - wanted_w) <= 64 * UNIT * terms[2]
    assume(wanted_w > 0.05)
    pixel_tolerance, w_tolerance = tolerances(terms, wanted, float(wanted_w))
    assert np.abs(got - wanted).max() <= 2 * pixel_tolerance
    assert abs(got_depth - wanted_depth) <= 2 * w_tolerance * max(float(wanted_depth), UNIT)


@given(neighbouring_views(), vectors())
def test_infinity_does_not_see_the_eye_move(views, elsewhere):
    frm, to = views
    moved = View(Pose(elsewhere, to.pose.orientation_xyzw), to.fov)
    here, there = WarpMap.between(frm, (64, 48), to, (50, 70)), WarpMap.between(frm, (64, 48), moved, (50, 70))
    assert np.array_equal(here.H, there.H)
    pixel, depth, w = here.apply(np.array([[3.5, 7.5]]), np.array([0.0]))
    assert depth == 0 or not w > 0
    assert np.array_equal(pixel, there.apply(np.array([[3.5, 7.5]]), np.array([0.0]))[0], equal_nan=True)


def test_known_map():
    # A square 90 degree view of 100 pixels (50 per tangent), the eye 0.1 m to the right: a point 1
    # m ahead moves left by 5 pixels.
    fov = Fov.symmetric(math.pi / 2, math.pi / 2)
    right = WarpMap.between(View(Pose(), fov), (100, 100), View(Pose((0.1, 0, 0)), fov), (100, 100))
    assert right.apply((50, 50), 1.0)[0] == pytest.approx([45, 50], abs=1e-12)
    assert right.apply((50, 50), 0.5)[0] == pytest.approx([47.5, 50], abs=1e-12)
    # 0.5 m forwards: what is 1 m ahead is at half the depth and twice as far from the middle.
    forwards = WarpMap.between(View(Pose(), fov), (100, 100), View(Pose((0, 0, -0.5)), fov), (100, 100))
    pixel, inverse_depth, w = forwards.apply((60, 45), 1.0)
    assert pixel == pytest.approx([70, 40], abs=1e-12)
    assert (inverse_depth, w) == (pytest.approx(2), pytest.approx(0.5))
    # 45 degrees to the left: what was straight ahead leaves through the right edge.
    left = Pose(orientation_xyzw=(0, math.sin(math.pi / 8), 0, math.cos(math.pi / 8)))
    turned = WarpMap.between(View(Pose(), fov), (100, 100), View(left, fov), (100, 100))
    assert turned.apply((50, 50), 0.0)[0] == pytest.approx([100, 50], abs=1e-12)


def test_beside_and_behind_there_is_no_picture():
    fov = Fov.symmetric(math.pi / 2, math.pi / 2)
    past = WarpMap.between(View(Pose(), fov), (10, 10), View(Pose((0, 0, -1)), fov), (10, 10))
    pixels, depth, w = past.apply(np.full((3, 2), 5.0), np.array([0.5, 1.0, 2.0]))
    assert w == pytest.approx([0.5, 0, -1])
    assert np.isfinite(pixels[0]).all()
    assert np.isnan(pixels[1:]).all()
    assert np.isnan(depth[1:]).all()


# --- whole pixels -------------------------------------------------------------------------------


@given(poses(st.sampled_from([0.0, 1.7, 1e6])), FOVS, SMALL_SIZES)
def test_the_same_pose_moves_whole_pixels(pose, fov, size):
    minus = Pose(pose.position_m, -pose.orientation_xyzw)
    for shown in (View(pose, fov), View(minus, fov), View(Pose(pose.position_m, pose.orientation_xyzw), fov)):
        warp = WarpMap.between(View(pose, fov), size, shown, size)
        assert warp.moves_whole_pixels()
        pixel = np.array(size) - 0.5
        assert np.abs(warp.apply(pixel, 2.0)[0] - pixel).max() <= 1e-6


@given(poses(), FOVS, st.floats(1, 1.5), SMALL_SIZES)
def test_cutting_off_a_guard_band_moves_whole_pixels(pose, fov, factor, size):
    assume(max(np.abs(fov.tangents)) * factor < 100)
    grown, grown_size = fov.guarded(factor, size)
    warp = WarpMap.between(View(pose, grown), grown_size, View(pose, fov), size)
    assert warp.moves_whole_pixels()
    landed = warp.apply(np.array([0.5, 0.5]), 1.0)[0] - 0.5
    assert np.abs(landed - np.round(landed)).max() <= 1e-6


ANY_STEP = st.sampled_from([1e-6, 1e-3, 0.5])


@given(poses(), st.integers(0, 5), ANY_STEP)
def test_any_motion_is_noticed(pose, kind, step):
    fov, size = Fov(-0.7, 0.8, -0.6, 0.5), (64, 48)
    axis = np.eye(3)[kind % 3] * step
    moved = (
        Pose(pose.position_m + axis, pose.orientation_xyzw) if kind < 3 else pose @ Pose((0, 0, 0), (*(axis / 2), 1))
    )
    assert not WarpMap.between(View(pose, fov), size, View(moved, fov), size).moves_whole_pixels()
    for scale, shift in ((2, 0), (0.5, 0), (1 + 1e-6, 0), (1, 1 / 64)):  # another scale, half a pixel
        other = Fov.from_tangents(scale * fov.tangents + (shift, shift, 0, 0))
        assert not WarpMap.between(View(pose, fov), size, View(pose, other), size).moves_whole_pixels()
