"""Rigid poses: where something is and how it is turned, in float64."""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from ..errors import InputError

Vector = NDArray[np.float64]


def frozen_vector(length: int):
    """A converter for attrs: `length` finite numbers as a float64 array that nobody writes to. Errors: InputError."""

    def convert(value: ArrayLike) -> Vector:
        try:
            array = np.array(value, dtype=np.float64)
        except (TypeError, ValueError) as error:  # text, ragged lists
            raise InputError(f"wanted {length} finite numbers, found {value!r}") from error
        if array.shape != (length,) or not np.isfinite(array).all():
            raise InputError(f"wanted {length} finite numbers, found {value!r}")
        array.flags.writeable = False
        return array

    return convert


def _unit_quaternion(value: ArrayLike) -> Vector:
    given = frozen_vector(4)(value)
    largest = float(np.abs(given).max())
    if largest == 0:
        raise InputError(f"a quaternion of length 0 is no rotation: {value!r}")
    # A quaternion already unit to the last bits stays as it is (normalising leaves up to 6 units of 1.1e-16): q -> Pose -> q is bit-exact.
    if largest <= 1 and abs(float(given @ given) - 1) < 1e-15:
        return given
    array = given / largest  # so that neither 1e-200 nor 1e200 under- or overflows in the norm
    array /= np.sqrt(array @ array)
    array.flags.writeable = False
    return array


@attrs.frozen(eq=False)
class Pose:
    """A rigid transform `a_from_b`: where frame b sits in frame a.

    Read `world_from_head` as "the head, in the world": points transform by `point_in_a = pose.transform(point_in_b)` and
    neighbours cancel in products, `world_from_head @ head_from_eye`.

    position_m: (3,) metres. orientation_xyzw: (4,) quaternion, x y z w, normalised here; q and -q are the same pose.
    Errors: InputError for values that are not finite and for a zero quaternion.
    """

    position_m: Vector = attrs.field(default=(0.0, 0.0, 0.0), converter=frozen_vector(3))
    orientation_xyzw: Vector = attrs.field(default=(0.0, 0.0, 0.0, 1.0), converter=_unit_quaternion)

    @property
    def rotation(self) -> Rotation:
        """The orientation as a SciPy rotation."""
        return Rotation.from_quat(self.orientation_xyzw)

    def transform(self, points: ArrayLike) -> Vector:
        """Points (..., 3) in b, in metres, to the same points in a."""
        points = np.asarray(points, dtype=np.float64)
        return points @ self.rotation.as_matrix().T + self.position_m

    def __matmul__(self, other: Pose) -> Pose:
        """a_from_b @ b_from_c = a_from_c."""
        return Pose(self.transform(other.position_m), (self.rotation * other.rotation).as_quat())

    def inverse(self) -> Pose:
        """b_from_a for a_from_b."""
        back = self.rotation.inv()
        return Pose(-back.as_matrix() @ self.position_m, back.as_quat())

    def relative_to(self, other: Pose) -> Pose:
        """other_from_self, for two poses in the same frame, without passing through that frame's origin.

        The positions are subtracted before anything is rotated, so two eyes 1 mm apart keep all their digits even
        1e6 m from the origin (the difference of neighbouring floats is exact, Sterbenz 1974).
        """
        back = other.rotation.inv()
        return Pose(back.as_matrix() @ (self.position_m - other.position_m), (back * self.rotation).as_quat())

    def towards(self, other: Pose, share: float) -> Pose:
        """The pose `share` (0..1) of the way to `other`: positions on the straight line, orientations on the shorter great arc.

        Source: Shoemake 1985, Animating Rotation with Quaternion Curves (SLERP).
        """
        turn = (self.rotation.inv() * other.rotation).as_rotvec()
        step = share * (other.position_m - self.position_m)
        return Pose(self.position_m + step, (self.rotation * Rotation.from_rotvec(share * turn)).as_quat())

    def matrix(self) -> NDArray[np.float64]:
        """The 4x4 homogeneous matrix."""
        out = np.eye(4)
        out[:3, :3] = self.rotation.as_matrix()
        out[:3, 3] = self.position_m
        return out

    def isclose(self, other: Pose, atol: float = 1e-9) -> bool:
        """The same pose within atol (metres, and radians of the angle between); q and -q count as one."""
        angle = (self.rotation.inv() * other.rotation).magnitude()
        return bool(np.abs(self.position_m - other.position_m).max() <= atol and angle <= atol)
