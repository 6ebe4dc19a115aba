"""Quaternion arithmetic on arrays (..., 4), xyzw, unit unless stated otherwise.

SciPy's Rotation objects cost more than the arithmetic for one pose and several copies for 10^7 of
them; the tests compare every function here against them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def multiply(a: Array, b: Array) -> Array:
    """Return the rotation b followed by a, (..., 4)."""
    ax, ay, az, aw = np.moveaxis(a, -1, 0)
    bx, by, bz, bw = np.moveaxis(b, -1, 0)
    x, y = aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx
    z, w = aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz
    return np.stack([x, y, z, w], axis=-1)


def conjugate(q: Array) -> Array:
    return np.asarray(q * np.array([-1.0, -1.0, -1.0, 1.0]))


def angle_between(a: Array, b: Array) -> Array:
    """Return the angle in radians, 0..pi, of the rotation from a to b.

    Exact to the last bits near 0 and near pi, unlike acos.
    Source: Kahan's formula for the angle between vectors (2006, How Futile are Mindless Assessments
    of Roundoff, section 12), applied to unit quaternions, whose angle is half that of the rotation.
    """
    apart, together = np.linalg.norm(a - b, axis=-1), np.linalg.norm(a + b, axis=-1)
    return np.asarray(4 * np.arctan2(np.minimum(apart, together), np.maximum(apart, together)))


def from_rotation_vector(v: Array) -> Array:
    """Return the exponential: rotation vectors (..., 3) in radians to quaternions."""
    angle = np.linalg.norm(v, axis=-1, keepdims=True)
    # sinc keeps all digits at angle 0; numpy's is sin(pi x)/(pi x).
    return np.concatenate([0.5 * np.sinc(angle / (2 * np.pi)) * v, np.cos(angle / 2)], axis=-1)


def to_rotation_vector(q: Array) -> Array:
    """Return the logarithm: quaternions to rotation vectors (..., 3) of length 0..pi."""
    q = np.where(q[..., 3:] < 0, -q, q)
    sine = np.linalg.norm(q[..., :3], axis=-1, keepdims=True)
    half = np.arctan2(sine, q[..., 3:])
    with np.errstate(divide="ignore", invalid="ignore"):
        factor = np.where(sine > 0, 2 * half / sine, 2.0)
    return q[..., :3] * factor


def vector_between(first: Array, then: Array) -> Array:
    """Return the rotation vectors (..., 3) from the first quaternions to the others."""
    return to_rotation_vector(multiply(then, conjugate(first)))


def rotate(q: Array, v: Array) -> Array:
    """Return vectors (..., 3) rotated by q."""
    u, w = q[..., :3], q[..., 3:]
    t = 2 * np.cross(u, v)
    return v + w * t + np.cross(u, t)


def make_continuous(q: Array) -> NDArray[np.intp]:
    """Flip signs in place so that neighbours lie in one hemisphere; return which did not."""
    flipped = np.einsum("ij,ij->i", q[1:], q[:-1]) < 0
    if flipped.any():
        q[np.flatnonzero(np.logical_xor.accumulate(flipped)) + 1] *= -1
    return np.flatnonzero(flipped) + 1


def slerp(a: Sequence[float], b: Sequence[float], share: float) -> list[float]:
    """Return one quaternion on the shorter arc from a (share 0) to b (share 1), in plain floats.

    2 us instead of SciPy's 60. Any angle from 0 to 180 degrees; at exactly 180 both arcs are
    equally short and the one through a + b is taken.
    """
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    if ax * bx + ay * by + az * bz + aw * bw < 0:
        bx, by, bz, bw = -bx, -by, -bz, -bw
    x, y, z, w = ax - bx, ay - by, az - bz, aw - bw
    apart = math.sqrt(x * x + y * y + z * z + w * w)
    x, y, z, w = ax + bx, ay + by, az + bz, aw + bw
    together = math.sqrt(x * x + y * y + z * z + w * w)
    angle = 2 * math.atan2(apart, together)
    sine = math.sin(angle)
    if sine == 0:
        return list(a)
    wa, wb = math.sin((1 - share) * angle) / sine, math.sin(share * angle) / sine
    return [wa * ax + wb * bx, wa * ay + wb * by, wa * az + wb * bz, wa * aw + wb * bw]


def turn(a: Sequence[float], b: Sequence[float]) -> tuple[float, float, float]:
    """Return the rotation vector, of length 0..pi, from a to b: one, in plain floats."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    x = bx * aw - bw * ax - by * az + bz * ay
    y = by * aw + bx * az - bw * ay - bz * ax
    z = bz * aw - bx * ay + by * ax - bw * az
    w = bw * aw + bx * ax + by * ay + bz * az
    sine = math.sqrt(x * x + y * y + z * z)
    if sine == 0:
        return 0.0, 0.0, 0.0
    factor = math.copysign(2 * math.atan2(sine, abs(w)) / sine, w)
    return factor * x, factor * y, factor * z


def turned(q: Sequence[float], v: Sequence[float]) -> tuple[float, float, float, float]:
    """Return q followed by the rotation vector v: one quaternion, in plain floats."""
    bx, by, bz, bw = q
    x, y, z = v
    angle = math.sqrt(x * x + y * y + z * z)
    factor = math.sin(angle / 2) / angle if angle > 0 else 0.5
    ax, ay, az, aw = factor * x, factor * y, factor * z, math.cos(angle / 2)
    return (
        aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz,
    )  # fmt: skip


def slerp_many(a: Array, b: Array, share: Array) -> Array:
    """Return `slerp` of arrays: a, b (n, 4), share (n,)."""
    b = np.where(np.einsum("ij,ij->i", a, b)[:, None] < 0, -b, b)
    angle = 2 * np.arctan2(np.linalg.norm(a - b, axis=1), np.linalg.norm(a + b, axis=1))
    sine = np.sin(angle)
    with np.errstate(divide="ignore", invalid="ignore"):
        wa = np.where(sine > 0, np.sin((1 - share) * angle) / sine, 1.0)
        wb = np.where(sine > 0, np.sin(share * angle) / sine, 0.0)
    return wa[:, None] * a + wb[:, None] * b
