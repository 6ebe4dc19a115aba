"""Poses are a group, q and -q are one rotation, and nothing is lost far from the origin."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from strategies import QUATERNIONS, UNIFORM_QUATERNIONS, poses, vectors

from hmdwarp.base import InputError
from hmdwarp.geometry import Pose

UNIT = 2.0**-53
# Positions here stay below 60 m after three products; a rotation is a sum of three products of unit
# entries, each good to a few units in the last place, and at most six of them are chained: 6 x 8
# units of 60 m is 3.2e-13.
ATOL = 4e-13


@given(poses())
def test_identity_and_inverse(pose):
    assert (Pose() @ pose).isclose(pose, ATOL) and (pose @ Pose()).isclose(pose, ATOL)
    assert (pose @ pose.inverse()).isclose(Pose(), ATOL)
    assert (pose.inverse() @ pose).isclose(Pose(), ATOL)
    assert pose.inverse().inverse().isclose(pose, ATOL)


@given(poses(), poses(), vectors())
def test_neighbouring_names_cancel(a_from_b, b_from_c, point_in_c):
    through = a_from_b.transform(b_from_c.transform(point_in_c))
    assert np.abs((a_from_b @ b_from_c).transform(point_in_c) - through).max() <= ATOL


def test_a_known_turn():
    # 90 degrees about +y takes -z (ahead) to -x (left): a positive yaw looks left in right-handed
    # axes with y up.
    left = Pose((1, 2, 3), (0, math.sqrt(0.5), 0, math.sqrt(0.5)))
    assert np.abs(left.transform((0, 0, -2)) - (-1, 2, 3)).max() <= 4 * UNIT


@given(vectors(), QUATERNIONS, poses(), vectors())
def test_q_and_minus_q_are_the_same_pose(position, q, other, point):
    plus, minus = Pose(position, q), Pose(position, -np.asarray(q))
    assert plus.isclose(minus, 0) and plus == minus and hash(plus) == hash(minus)
    assert plus != Pose(np.nextafter(plus.position_m, np.inf), q)
    assert np.array_equal(plus.transform(point), minus.transform(point))
    assert np.array_equal(plus.matrix(), minus.matrix())
    assert (other @ plus).isclose(other @ minus, ATOL)
    assert plus.relative_to(other).isclose(minus.relative_to(other), ATOL)


@given(UNIFORM_QUATERNIONS, st.integers(-200, 200))
def test_the_length_of_a_quaternion_does_not_matter(q, exponent):
    # Scaling rounds each component by half a unit, normalising by a few more.
    got = Pose(orientation_xyzw=q * 10.0**exponent).orientation_xyzw
    assert np.abs(got - q / np.linalg.norm(q)).max() <= 8 * UNIT
    assert abs(got @ got - 1) <= 4 * UNIT


@given(QUATERNIONS, vectors())
def test_a_stored_pose_is_read_back_bit_for_bit(q, position):
    once = Pose(position, q)
    twice = Pose(once.position_m, once.orientation_xyzw)
    # Normalising may need a second step to settle; from then on nothing moves.
    settled = Pose(twice.position_m, twice.orientation_xyzw)
    assert np.array_equal(settled.orientation_xyzw, twice.orientation_xyzw)
    assert np.array_equal(settled.position_m, np.array(position))


@given(
    vectors(st.sampled_from([1e6, -1e6, 999_999.875])), vectors(st.integers(-8, 8).map(lambda n: n / 1024)), QUATERNIONS
)
def test_relative_to_keeps_a_millimetre_a_thousand_kilometres_out(origin, step, q):
    """Steps of 1/1024 m are representable at 1e6 m, so the difference is known exactly and only the
    turn rounds."""
    eye, other = Pose(np.array(origin) + step, q), Pose(origin, q)
    wanted = other.rotation.as_matrix().T @ np.array(step)
    assert np.abs(eye.relative_to(other).position_m - wanted).max() <= 8 * UNIT * 8 / 1024


def test_what_is_no_pose_is_refused():
    for axis in range(4):
        for bad in (math.nan, math.inf, -math.inf):
            q, p = [0.1, 0.2, 0.3, 0.9], [1.0, 2.0, 3.0]
            q[axis] = p[axis % 3] = bad
            with pytest.raises(InputError, match="4 finite numbers"):
                Pose((1, 2, 3), q)
            with pytest.raises(InputError, match="3 finite numbers"):
                Pose(p)
    with pytest.raises(InputError, match="no rotation"):
        Pose((0, 0, 0), (0.0, -0.0, 0.0, -0.0))
    for value in ((1, 2), [[1, 2, 3]], 3.0, "abc", ("1", "x", "2"), (1, (2, 3), 4), None, ()):
        with pytest.raises(InputError, match="3 finite numbers"):
            Pose(value)
    far = Pose((1.7e308, 0, 0))
    with pytest.raises(InputError, match="3 finite numbers"), np.errstate(over="ignore"):
        far @ far


def test_a_pose_cannot_be_changed_and_does_not_follow_what_it_was_made_of():
    position, q = np.zeros(3), np.array([0, 0, 0, 1.0])
    pose = Pose(position, q)
    position[0], q[0] = 5, 5
    assert np.array_equal(pose.position_m, (0, 0, 0))
    assert np.array_equal(pose.orientation_xyzw, (0, 0, 0, 1))
    for array in (pose.position_m, pose.orientation_xyzw, Pose((0, 0, 0), (1, 2, 3, 4)).orientation_xyzw):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1


@given(poses(), st.floats(1e-6, 3), st.floats(1e-6, 3))
def test_isclose_sees_angle_and_distance(pose, angle, distance):
    turned = Pose(pose.position_m, (pose.rotation * Rotation.from_rotvec([0, angle, 0])).as_quat())
    assert not pose.isclose(turned, angle * 0.99)
    assert pose.isclose(turned, angle * 1.01)
    moved = Pose(pose.position_m + (0, distance, 0), pose.orientation_xyzw)
    assert not pose.isclose(moved, distance * 0.99)
    assert pose.isclose(moved, distance * 1.01)


SHARES = st.floats(0, 1)


@given(poses(), poses(), SHARES)
def test_towards_goes_straight_and_at_an_even_rate(pose, other, share):
    there = pose.towards(other, share)
    whole = pose.angle_to(other)
    assert np.abs(there.position_m - (pose.position_m + share * (other.position_m - pose.position_m))).max() <= ATOL
    assert abs(pose.angle_to(there) - share * whole) <= 1e-7
    assert abs(there.angle_to(other) - (1 - share) * whole) <= 1e-7
    assert pose.angle_to(there) <= math.pi * share + 1e-7, "never the longer way"


# Another order of a sum of four products of numbers up to 1, and a square root: a few units in the
# last place.
SUMMED = 8 * UNIT


@given(poses(), poses())
def test_turns_are_those_of_scipy(pose, other):
    """The formulas are written out in plain floats; SciPy's own are the twin."""
    assert np.abs(pose.rotation_matrix - pose.rotation.as_matrix()).max() <= SUMMED
    assert np.abs((pose @ other).orientation_xyzw - (pose.rotation * other.rotation).as_quat()).max() <= SUMMED
    assert np.abs(pose.inverse().orientation_xyzw - pose.rotation.inv().as_quat()).max() <= SUMMED
    between = (other.rotation.inv() * pose.rotation).as_quat()
    assert np.abs(pose.relative_to(other).orientation_xyzw - between).max() <= SUMMED


@given(poses(), poses())
def test_products_are_what_the_constructor_would_make(pose, other):
    """The short way there asks less, and makes the same bits."""
    for made in (pose @ other, pose.relative_to(other)):
        again = Pose(made.position_m, made.orientation_xyzw)
        assert np.array_equal(made.orientation_xyzw, again.orientation_xyzw)
        assert np.array_equal(made.rotation_matrix, again.rotation_matrix)
        assert not (made.position_m.flags.writeable or made.orientation_xyzw.flags.writeable)


@pytest.mark.parametrize("seed", range(20))
def test_a_matrix_is_the_pose_that_takes_points_as_it_does(seed):
    rng = np.random.default_rng(seed)
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = Rotation.random(random_state=rng).as_matrix(), rng.normal(size=3)
    points = rng.normal(size=(5, 3))
    expected = (np.c_[points, np.ones(5)] @ matrix.T)[:, :3]
    for form in (matrix, matrix[:3], matrix.T, matrix.T.ravel()):
        np.testing.assert_allclose(Pose.from_matrix(form).transform(points), expected, atol=1e-12)
    for wrong in (matrix * 2, np.diag([1, 1, -1, 1]) @ matrix, matrix[:3, :3], matrix * np.nan):
        with pytest.raises(InputError, match="matrix is"):
            Pose.from_matrix(wrong)
