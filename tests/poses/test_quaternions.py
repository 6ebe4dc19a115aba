"""Quaternion arithmetic against SciPy, which computes it by other routes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

from hmdwarp.poses import quaternions

from .traces import unit_quaternions

# A product of unit quaternions sums four products of numbers below 1: a few units of 1.1e-16 each,
# doubled by going to an angle.
ATOL = 5e-15


def angle(a, b) -> float:
    return float((Rotation.from_quat(a).inv() * Rotation.from_quat(b)).magnitude())


@given(unit_quaternions, unit_quaternions)
def test_product_inverse_and_rotation_are_scipys(a, b):
    assert angle(quaternions.multiply(a, b), (Rotation.from_quat(a) * Rotation.from_quat(b)).as_quat()) < ATOL
    assert angle(quaternions.conjugate(a), Rotation.from_quat(a).inv().as_quat()) < ATOL
    v = np.array([0.3, -2.0, 5.0])
    assert np.allclose(quaternions.rotate(a, v), Rotation.from_quat(a).apply(v), rtol=0, atol=5e-14)


@given(unit_quaternions)
def test_log_and_exp_are_inverse_and_scipys(q):
    log = quaternions.to_rotation_vector(q)
    assert np.linalg.norm(log) <= np.pi + 1e-12
    assert angle(quaternions.from_rotation_vector(log), q) < ATOL


@given(unit_quaternions, unit_quaternions, st.sampled_from([0.0, 1e-12, 1.0]))
def test_turns_of_one_in_plain_floats_are_scipys(a, b, share):
    """From one towards the other, by all, next to nothing or nothing: there and back."""
    wanted = (
        Rotation.from_quat(a),
        Rotation.from_rotvec(share * (Rotation.from_quat(b) * Rotation.from_quat(a).inv()).as_rotvec()),
    )
    q = quaternions.turned(a.tolist(), wanted[1].as_rotvec().tolist())
    assert angle(q, (wanted[1] * wanted[0]).as_quat()) < 2 * ATOL
    v = np.array(quaternions.turn(a.tolist(), q))
    assert np.linalg.norm(v) <= np.pi + 1e-12
    assert angle(Rotation.from_rotvec(v).as_quat(), wanted[1].as_quat()) < 3 * ATOL  # three products


@given(unit_quaternions, st.floats(0, 1))
def test_slerp_is_scipys(a, share):
    b = quaternions.multiply(quaternions.from_rotation_vector(np.array([0.2, -0.7, 0.4])), a)
    wanted = Slerp([0, 1], Rotation.from_quat([a, b]))(share).as_quat()
    assert angle(quaternions.slerp(a.tolist(), b.tolist(), share), wanted) < 2e-14
    many = quaternions.slerp_many(a[None], b[None], np.array([share]))[0]
    assert np.allclose(many, quaternions.slerp(a.tolist(), b.tolist(), share), rtol=0, atol=1e-15)


@pytest.mark.parametrize("turn_rad", [0.0, 1e-300, 1e-12, 1e-8, 1e-3, 1.0, np.pi - 1e-8, np.pi])
@pytest.mark.parametrize("share", [0.0, 0.25, 0.5, 1.0])
@given(unit_quaternions)
def test_slerp_turns_by_its_share_of_any_angle(turn_rad, share, a):
    axis = np.array([1.0, 2.0, -2.0]) / 3
    b = quaternions.multiply(quaternions.from_rotation_vector(turn_rad * axis), a)
    q = np.array(quaternions.slerp(a.tolist(), b.tolist(), share))
    # Near 180 degrees the arc may run either way round: the angle from a is the same.
    assert abs(np.linalg.norm(q) - 1) < 1e-14
    assert abs(float(quaternions.angle_between(a, q)) - share * turn_rad) < 1e-14


@given(st.lists(st.booleans(), min_size=1, max_size=30))
def test_signs_become_continuous_without_changing_a_rotation(flips):
    smooth = quaternions.from_rotation_vector(np.linspace(0, 5, len(flips))[:, None] * np.array([0.1, 1.0, 0.2]))
    flipped = np.where(np.array(flips)[:, None], -smooth, smooth)
    mended = flipped.copy()
    changes = sum(a != b for a, b in zip(flips, flips[1:], strict=False))
    if len(flips) > 10:  # steps are then below 90 degrees of quaternion arc, so a negative product can only be a flip
        assert len(quaternions.make_continuous(mended)) == changes
    else:
        quaternions.make_continuous(mended)
    assert (np.einsum("ij,ij->i", mended[1:], mended[:-1]) >= 0).all()
    assert np.array_equal(np.abs(mended), np.abs(flipped))
    assert np.array_equal(mended[0], flipped[0])
