"""Rigid poses: position and orientation, in float64."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base import NO_NUMBERS, InputError, in_brief

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation  # 0.3 s, which a command that turns nothing need not wait for

Vector = NDArray[np.float64]
Quaternion = tuple[float, float, float, float]
MOST_M = 1e9  # of a coordinate: doubles are 0.1 um apart there; the earth's radius is 6.4e6


def real(value: float) -> float:
    """Return a number as a float. Errors: InputError."""
    try:
        return float(value)
    except NO_NUMBERS as error:
        raise InputError(f"expected a number, found {in_brief(value)}") from error


def floats(value: ArrayLike, wanted: str = "numbers") -> Vector:
    """Return numbers of any shape as a float64 array. Errors: InputError."""
    try:
        return np.asarray(value, dtype=np.float64)
    except NO_NUMBERS as error:
        raise InputError(f"expected {wanted}, found {in_brief(value)}") from error


def frozen(value: ArrayLike, length: int = 3, wanted: str = "") -> Vector:
    """Return so many finite numbers as a read-only float64 array of its own. Errors: InputError."""
    array = np.array(floats(value, wanted := wanted or f"{length} finite numbers"))
    # The sum is quick, and finite unless an element is not; sums beyond 1e308 need a second look.
    if array.shape != (length,) or not (math.isfinite(sum(array.tolist())) or np.isfinite(array).all()):
        raise InputError(f"expected {wanted}, found {in_brief(value)}")
    array.setflags(write=False)
    return array


def _unit_quaternion(value: ArrayLike) -> Vector:
    given = frozen(value, 4)
    x, y, z, w = given.tolist()
    largest = max(abs(x), abs(y), abs(z), abs(w))
    if largest == 0:
        raise InputError(f"a quaternion of length 0 is no rotation: {in_brief(value)}")
    # A quaternion already unit to the last bits stays as it is (normalising leaves up to 6 units of
    # 1.1e-16): q -> Pose -> q is bit-exact.
    if largest <= 1 and abs(x * x + y * y + z * z + w * w - 1) < 1e-15:
        return given
    array: Vector = given / largest  # so that neither 1e-200 nor 1e200 under- or overflows in the norm
    return frozen(array / np.sqrt(array @ array), 4)


# Rotations in plain floats, by SciPy's own formulas in its order of operations, so bit for bit the
# same. A SciPy object costs 15 us, and a refresh would make twenty.


def matrix_of(q: Sequence[float]) -> Vector:
    """Return the matrix of a quaternion, which is normalised first; read-only."""
    x, y, z, w = q
    length = math.sqrt(x * x + y * y + z * z + w * w)
    x, y, z, w = x / length, y / length, z / length, w / length
    xx, yy, zz, ww = x * x, y * y, z * z, w * w
    xy, zw, xz, yw, yz, xw = x * y, z * w, x * z, y * w, y * z, x * w
    matrix = np.array(
        (
            (xx - yy - zz + ww, 2 * (xy - zw), 2 * (xz + yw)),
            (2 * (xy + zw), -xx + yy - zz + ww, 2 * (yz - xw)),
            (2 * (xz - yw), 2 * (yz + xw), -xx - yy + zz + ww),
        )
    )
    matrix.flags.writeable = False
    return matrix


def _product(a: Quaternion, b: Quaternion) -> Quaternion:
    """Return the rotation b followed by a, normalised."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    x = aw * bx + bw * ax + (ay * bz - az * by)
    y = aw * by + bw * ay + (az * bx - ax * bz)
    z = aw * bz + bw * az + (ax * by - ay * bx)
    w = aw * bw - ax * bx - ay * by - az * bz
    length = math.sqrt(x * x + y * y + z * z + w * w)
    return x / length, y / length, z / length, w / length


@attrs.frozen
class Pose:
    """A rigid transform `a_from_b`: where frame b sits in frame a.

    Read `world_from_head` as "the head, in the world": points transform by `point_in_a =
    pose.transform(point_in_b)` and neighbours cancel in products, `world_from_head @
    head_from_eye`.

    Parameters
    ----------
    position_m : array_like
        (3,), in metres.
    orientation_xyzw : array_like
        (4,), a quaternion x y z w, normalised here; q and -q are the same pose.

    Raises
    ------
    InputError
        For values that are not finite and for a zero quaternion.
    """

    position_m: Vector = attrs.field(default=(0.0, 0.0, 0.0), converter=frozen, eq=lambda place: tuple(place.tolist()))
    orientation_xyzw: Vector = attrs.field(default=(0.0, 0.0, 0.0, 1.0), converter=_unit_quaternion, eq=False)
    # The orientation in plain floats, x y z w, as SciPy takes it: normalised once more.
    unit_quaternion: Quaternion = attrs.field(init=False, repr=False, eq=lambda q: max(q, tuple(-part for part in q)))

    @unit_quaternion.default
    def _unit_of_orientation(self) -> Quaternion:
        x, y, z, w = self.orientation_xyzw.tolist()
        length = math.sqrt(x * x + y * y + z * z + w * w)
        return x / length, y / length, z / length, w / length

    def check_near(self, what: str) -> None:
        """Raise InputError for a pose of a user beyond MOST_M."""
        if max(map(abs, self.position_m.tolist())) > MOST_M:
            raise InputError(f"{what}: position {self.position_m.tolist()}: expected at most {MOST_M:g} m")

    @property
    def rotation(self) -> Rotation:
        """The orientation as a SciPy rotation."""
        from scipy.spatial.transform import Rotation

        return Rotation.from_quat(self.orientation_xyzw)

    @cached_property
    def rotation_matrix(self) -> Vector:
        """The orientation as a 3x3 matrix, read-only."""
        return matrix_of(self.orientation_xyzw.tolist())

    @classmethod
    def from_matrix(cls, matrix: ArrayLike) -> Pose:
        """Return the pose that a matrix is: (4, 4) or (3, 4), or 16 numbers by columns, as WebXR.

        Of (4, 4) the position stands in the last column, or in the last row. Errors: InputError
        for one that does more than turn and move.
        """
        from scipy.spatial.transform import Rotation

        found = floats(matrix)
        found = found.reshape(4, 4).T if found.shape == (16,) else found
        if found.shape == (4, 4) and not np.allclose(found[3], (0, 0, 0, 1)):
            found = found.T
        turn, whole = found[:3, :3], found.shape in ((3, 4), (4, 4)) and np.isfinite(found).all()
        if not whole or not np.allclose(found[3:], (0, 0, 0, 1)) or np.abs(turn @ turn.T - np.eye(3)).max() > 1e-3:
            raise InputError(f"matrix is {in_brief(matrix)}: expected (4, 4), (3, 4) or 16 numbers that turn and move")
        if np.linalg.det(turn) < 0:
            raise InputError(f"matrix is {in_brief(matrix)}: it mirrors; expected a right-handed rotation")
        return cls(found[:3, 3], Rotation.from_matrix(turn).as_quat())

    def transform(self, points: ArrayLike) -> Vector:
        """Transform points (..., 3) in b, in metres, to the same points in a."""
        points = floats(points)
        if points.shape[-1:] != (3,):
            raise InputError(f"points have shape {points.shape}: expected (.., 3)")
        return points @ self.rotation_matrix.T + self.position_m

    def __matmul__(self, other: Pose) -> Pose:
        """Return a_from_b @ b_from_c = a_from_c. Errors: InputError for points: transform them."""
        if type(other) is not Pose:
            _check_pose(other)
        position = other.position_m @ self.rotation_matrix.T + self.position_m
        return trusted_pose(position, _product(self.unit_quaternion, other.unit_quaternion))

    def inverse(self) -> Pose:
        """Return b_from_a for a_from_b."""
        x, y, z, w = self.unit_quaternion
        return Pose(-self.rotation_matrix.T.copy() @ self.position_m, (-x, -y, -z, w))

    def relative_to(self, other: Pose) -> Pose:
        """Return other_from_self for two poses in the same frame, without passing its origin.

        Two eyes 1 mm apart keep all their digits 1e6 m from it: positions are subtracted first.
        """
        if type(other) is not Pose:
            _check_pose(other)
        x, y, z, w = other.unit_quaternion
        # A copy, as BLAS adds up in another order where a matrix is transposed.
        position = other.rotation_matrix.T.copy() @ (self.position_m - other.position_m)
        return trusted_pose(position, _product((-x, -y, -z, w), self.unit_quaternion))

    def towards(self, other: Pose, share: float) -> Pose:
        """Return the pose `share` (0..1) of the way to `other`.

        Positions lie on the straight line, orientations on the shorter great arc.
        Source: Shoemake 1985, Animating Rotation with Quaternion Curves (SLERP).
        """
        from scipy.spatial.transform import Rotation

        _check_pose(other)
        (share,) = frozen([share], 1).tolist()
        turn = (self.rotation.inv() * other.rotation).as_rotvec()
        step = share * (other.position_m - self.position_m)
        return Pose(self.position_m + step, (self.rotation * Rotation.from_rotvec(share * turn)).as_quat())

    def matrix(self) -> Vector:
        """Return the 4x4 homogeneous matrix."""
        out = np.eye(4)
        out[:3, :3] = self.rotation_matrix
        out[:3, 3] = self.position_m
        return out

    def angle_to(self, other: Pose) -> float:
        """Return the angle of the rotation between both poses, in radians from 0 to pi."""
        _check_pose(other)
        return float((self.rotation.inv() * other.rotation).magnitude())

    def isclose(self, other: Pose, atol: float = 1e-9) -> bool:
        """Return whether both poses agree within atol: metres, and radians of the angle between."""
        return bool(self.angle_to(other) <= atol and np.abs(self.position_m - other.position_m).max() <= atol)


def _check_pose(other: object) -> None:
    if not isinstance(other, Pose):
        raise InputError(f"expected a hmdwarp.Pose, found {in_brief(other)}; points are for Pose.transform")


_set = object.__setattr__


def trusted_pose(position: Vector, turn: Sequence[float]) -> Pose:
    """Return Pose(position, turn) of a new array and a normalised quaternion, in half the time."""
    x, y, z, w = turn
    length = math.sqrt(x * x + y * y + z * z + w * w)
    is_unit = max(turn) <= 1 and min(turn) >= -1 and abs(x * x + y * y + z * z + w * w - 1) < 1e-15
    if not (is_unit and math.isfinite(sum(position.tolist()))):
        return Pose(position, turn)
    pose, orientation = Pose.__new__(Pose), np.array(turn)
    position.flags.writeable = orientation.flags.writeable = False
    _set(pose, "position_m", position)
    _set(pose, "orientation_xyzw", orientation)
    _set(pose, "unit_quaternion", (x / length, y / length, z / length, w / length))
    _set(pose, "rotation_matrix", matrix_of(turn))
    return pose


@attrs.frozen(eq=False)
class RigidState:
    """world_from_body at one instant, and its motion in world axes."""

    pose: Pose
    velocity_m_s: Vector = attrs.field(default=(0.0, 0.0, 0.0), converter=frozen)  # of the body's origin
    angular_velocity_rad_s: Vector = attrs.field(default=(0.0, 0.0, 0.0), converter=frozen)  # right-handed about it
    acceleration_m_s2: Vector = attrs.field(default=(0.0, 0.0, 0.0), converter=frozen)  # of it; gravity where thrown

    def after(self, age_ns: int) -> Pose:
        """Return world_from_body `age_ns` later, at constant acceleration and angular velocity."""
        from scipy.spatial.transform import Rotation

        seconds = age_ns * 1e-9
        position = self.pose.position_m + seconds * (self.velocity_m_s + 0.5 * seconds * self.acceleration_m_s2)
        turned = Rotation.from_rotvec(self.angular_velocity_rad_s * seconds) * self.pose.rotation
        return Pose(position, turned.as_quat())
