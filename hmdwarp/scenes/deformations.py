"""Deformations of meshes: cloth in the wind, skins over joints.

They are pure functions of the scene's clock, in float64.

Source: Magnenat-Thalmann et al. 1988, Joint-Dependent Local Deformations (linear blend skinning).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import SceneError

Array = NDArray[np.float64]


def _points(value: ArrayLike) -> Array:
    array = np.array(value, np.float64)
    if array.ndim != 2 or array.shape[1] != 3 or not np.isfinite(array).all():
        raise SceneError(f"deformation: expected (n, 3) finite numbers, found shape {array.shape}, or not all finite")
    return array


def _point(value: ArrayLike) -> Array:
    return np.asarray(_points(np.array([value]))[0])


def _array(value: ArrayLike) -> Array:
    return np.array(value, np.float64)


def _direction(value: ArrayLike) -> Array:
    array = np.array(value, np.float64)
    if array.shape != (3,) or not np.isfinite(array).all() or not np.linalg.norm(array) > 0:
        raise SceneError(f"deformation: expected a direction of three finite numbers longer than 0, found {value!r}")
    return array / np.linalg.norm(array)


@attrs.frozen(eq=False)
class Waving:
    """Cloth held along one edge; waves run out from it and grow with the distance.

    Errors: SceneError for counts that differ, numbers that are not finite, and a wave length or
    period of 0.
    """

    rest: Array = attrs.field(converter=_points)  # (n, 3) vertices without wind, metres
    away: Array = attrs.field(converter=_array)  # (n,) metres of each vertex from the held edge
    out: Array = attrs.field(converter=_direction)  # direction in which the cloth swings, of any length
    height_m: float = 0.1  # amplitude at 1 m from the edge
    length_m: float = 1.0  # length of a wave
    period_s: float = 1.0
    lag: Array | float = 0.0  # (n,) additional phase lag of each vertex in waves: the cloth does not swing as a board

    def __attrs_post_init__(self) -> None:
        if self.away.shape != (len(self.rest),) or not np.isfinite(self.away).all():
            found = f"{len(self.rest)} points and distances of shape {self.away.shape}"
            raise SceneError(f"waving: {found}: expected a finite one for each point")
        if not (
            self.length_m > 0 and self.period_s > 0 and np.isfinite([self.height_m, self.length_m, self.period_s]).all()
        ):
            raise SceneError(f"waving: length {self.length_m:g} m, period {self.period_s:g} s: expected both above 0")

    def _swing(self, time_ns: int, quarter: int) -> Array:
        """Return the share of the full swing; quarter: 1 for a quarter of a period later."""
        phase = time_ns * 1e-9 / self.period_s - self.away / self.length_m - self.lag + 0.25 * quarter
        return np.sin(2 * np.pi * phase)

    def positions(self, time_ns: int) -> Array:
        """Return (n, 3) metres relative to the scene's origin."""
        return self.rest + (self.height_m * self.away * self._swing(time_ns, 0))[:, None] * self.out

    def velocities(self, time_ns: int) -> Array:
        """Return (n, 3) m/s in world axes."""
        speed = 2 * np.pi / self.period_s * self.height_m * self.away * self._swing(time_ns, 1)
        return speed[:, None] * self.out


@attrs.frozen(eq=False)
class Joint:
    """A swinging hinge; its angle is `middle_rad` + `swing_rad` * sin of the phase.

    Errors: SceneError for an axis of length 0, numbers that are not finite and a period of 0.
    """

    name: str
    parent: int  # index of the parent joint, lower than this joint's own; -1 for none
    pivot: Array = attrs.field(converter=_point)  # (3,) at rest, metres relative to the scene's origin
    axis: Array = attrs.field(converter=_direction)  # angles are right-handed about it
    swing_rad: float = 0.0
    middle_rad: float = 0.0
    period_s: float = 1.0
    phase: float = 0.0  # share of a period, 0 to 1

    def __attrs_post_init__(self) -> None:
        if not np.isfinite([self.swing_rad, self.middle_rad, self.period_s, self.phase]).all() or not self.period_s > 0:
            raise SceneError(
                f"joint '{self.name}': expected finite angles and a period above 0, found period {self.period_s:g} s"
            )

    def turn(self, time_ns: int) -> tuple[Array, Array]:
        """Return 4x4 parent_from_joint, both in rest coordinates, and its change in 1/s."""
        from scipy.spatial.transform import Rotation

        place = 2 * np.pi * (time_ns * 1e-9 / self.period_s + self.phase)
        rotation = Rotation.from_rotvec(self.axis * (self.middle_rad + self.swing_rad * np.sin(place))).as_matrix()
        rate = self.swing_rad * np.cos(place) * 2 * np.pi / self.period_s
        x, y, z = self.axis * rate
        change = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) @ rotation
        moved, moving = np.eye(4), np.zeros((4, 4))
        moved[:3, :3], moved[:3, 3] = rotation, self.pivot - rotation @ self.pivot
        moving[:3, :3], moving[:3, 3] = change, -change @ self.pivot
        return moved, moving


def _joints(value: Iterable[Joint]) -> tuple[Joint, ...]:
    return tuple(value)


def _indices(value: ArrayLike) -> NDArray[np.int64]:
    return np.array(value, np.int64)


@attrs.frozen(eq=False)
class Skinned:
    """A skin over joints: each vertex follows the weighted mean of its joints.

    Errors: SceneError for an unknown joint, a parent that does not precede its child, and weights
    that do not sum to 1.
    """

    rest: Array = attrs.field(converter=_points)  # (n, 3) metres
    joints: Sequence[Joint] = attrs.field(converter=_joints)  # parents before children
    which: NDArray[np.int64] = attrs.field(converter=_indices)  # (n, k) indices into joints
    weights: Array = attrs.field(converter=_array)  # (n, k), 0 or more, of sum 1

    def __attrs_post_init__(self) -> None:
        if self.which.ndim != 2 or len(self.which) != len(self.rest) or self.weights.shape != self.which.shape:
            found = f"{len(self.rest)} points, joints {self.which.shape}, weights {self.weights.shape}"
            raise SceneError(f"skin: {found}: expected (n, k) for both")
        self._check_joints()
        bad = ~(
            np.isfinite(self.weights).all(axis=1)
            & (self.weights >= 0).all(axis=1)
            & (np.abs(self.weights.sum(axis=1) - 1) <= 1e-4)
        )
        if bad.any():
            vertex = int(np.argmax(bad))
            raise SceneError(
                f"skin: weights {self.weights[vertex]} of vertex {vertex}: expected 0 or more each, with sum 1"
            )

    def _check_joints(self) -> None:
        for index, joint in enumerate(self.joints):
            if not -1 <= joint.parent < index:
                raise SceneError(
                    f"joint '{joint.name}', number {index}, hangs from joint {joint.parent}: "
                    "expected -1 or one before it"
                )
        beyond = (self.which < 0) | (self.which >= len(self.joints))
        if beyond.any():
            vertex = int(np.argmax(beyond.any(axis=1)))
            raise SceneError(
                f"skin: vertex {vertex} uses joint {self.which[vertex].max()}, there are {len(self.joints)}"
            )

    def _blended(self, time_ns: int) -> tuple[Array, Array]:
        """Return (n, 3, 4) transforms of the vertices, and their change in 1/s."""
        moved: list[Array] = []
        moving: list[Array] = []
        for joint in self.joints:
            turn, change = joint.turn(time_ns)
            above = (moved[joint.parent], moving[joint.parent]) if joint.parent >= 0 else (np.eye(4), np.zeros((4, 4)))
            moved.append(above[0] @ turn)
            moving.append(above[1] @ turn + above[0] @ change)

        def blend(matrices: list[Array]) -> Array:
            return np.asarray(np.einsum("nk,nkij->nij", self.weights, np.array(matrices)[:, :3][self.which]))

        return blend(moved), blend(moving)

    def _applied(self, matrices: Array) -> Array:
        return np.asarray(np.einsum("nij,nj->ni", matrices[:, :, :3], self.rest) + matrices[:, :, 3])

    def positions(self, time_ns: int) -> Array:
        """Return (n, 3) metres relative to the scene's origin."""
        return self._applied(self._blended(time_ns)[0])

    def velocities(self, time_ns: int) -> Array:
        """Return (n, 3) m/s in world axes."""
        return self._applied(self._blended(time_ns)[1])
