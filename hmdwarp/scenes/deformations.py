"""How meshes deform: cloth in the wind, and skins over joints. Each is a pure function of the scene's clock, in float64.

Source: Magnenat-Thalmann et al. 1988, Joint-Dependent Local Deformations (linear blend skinning).
"""

from __future__ import annotations

from collections.abc import Sequence

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from ..errors import SceneError

Array = NDArray[np.float64]


def _points(value: ArrayLike) -> Array:
    array = np.array(value, np.float64)
    if array.ndim != 2 or array.shape[1] != 3 or not np.isfinite(array).all():
        raise SceneError(
            f"deformation: wanted (n, 3) finite numbers, found shape {array.shape}{'' if array.ndim != 2 else ' with others'}"
        )
    return array


def _direction(value: ArrayLike) -> Array:
    array = np.array(value, np.float64)
    if array.shape != (3,) or not np.isfinite(array).all() or not np.linalg.norm(array) > 0:
        raise SceneError(f"deformation: wanted a direction of three finite numbers longer than 0, found {value!r}")
    return array / np.linalg.norm(array)


@attrs.frozen(eq=False)
class Waving:
    """Cloth held along one edge: waves run out from it and grow with the distance.

    rest: (n, 3) where the vertices are without wind. away: (n,) metres of each from the edge that is held. out: the direction the cloth
    swings in. height_m: how far at 1 m from the edge. length_m: of a wave. period_s: of a swing. lag: (n,) waves by which a vertex is
    behind besides, so that the cloth does not swing as a board.
    Errors: SceneError for counts that differ, numbers that are not finite, and a wave length or period of 0.
    """

    rest: Array = attrs.field(converter=_points)
    away: Array = attrs.field(converter=lambda value: np.array(value, np.float64))
    out: Array = attrs.field(converter=_direction)
    height_m: float = 0.1
    length_m: float = 1.0
    period_s: float = 1.0
    lag: Array | float = 0.0

    def __attrs_post_init__(self) -> None:
        if self.away.shape != (len(self.rest),) or not np.isfinite(self.away).all():
            found = f"{len(self.rest)} points and distances of shape {self.away.shape}"
            raise SceneError(f"waving: {found}: wanted a finite one for each point")
        if not (
            self.length_m > 0 and self.period_s > 0 and np.isfinite([self.height_m, self.length_m, self.period_s]).all()
        ):
            raise SceneError(f"waving: length {self.length_m:g} m, period {self.period_s:g} s: wanted both above 0")

    def _swing(self, time_ns: int, quarter: int) -> Array:
        """Share of the full swing; quarter: 1 for what is a quarter of a period later."""
        phase = time_ns * 1e-9 / self.period_s - self.away / self.length_m - self.lag + 0.25 * quarter
        return np.sin(2 * np.pi * phase)

    def positions(self, time_ns: int) -> Array:
        """(n, 3) metres relative to the scene's origin."""
        return self.rest + (self.height_m * self.away * self._swing(time_ns, 0))[:, None] * self.out

    def velocities(self, time_ns: int) -> Array:
        """(n, 3) m/s in world axes."""
        speed = 2 * np.pi / self.period_s * self.height_m * self.away * self._swing(time_ns, 1)
        return speed[:, None] * self.out


@attrs.frozen(eq=False)
class Joint:
    """A hinge that swings: its angle is `middle_rad` + `swing_rad` * sin of the phase, right-handed about `axis`.

    parent: index of the joint it hangs from, one before it; -1 for none. pivot: (3,) at rest, metres relative to the scene's origin.
    Errors: SceneError for an axis of length 0, numbers that are not finite and a period of 0.
    """

    name: str
    parent: int
    pivot: Array = attrs.field(converter=lambda value: _points([value])[0])
    axis: Array = attrs.field(converter=_direction)
    swing_rad: float = 0.0
    middle_rad: float = 0.0
    period_s: float = 1.0
    phase: float = 0.0

    def __attrs_post_init__(self) -> None:
        if not np.isfinite([self.swing_rad, self.middle_rad, self.period_s, self.phase]).all() or not self.period_s > 0:
            raise SceneError(
                f"joint '{self.name}': wanted finite angles and a period above 0, found period {self.period_s:g} s"
            )

    def turn(self, time_ns: int) -> tuple[Array, Array]:
        """4x4 parent_from_joint, both in rest coordinates, and its change in 1/s."""
        place = 2 * np.pi * (time_ns * 1e-9 / self.period_s + self.phase)
        rotation = Rotation.from_rotvec(self.axis * (self.middle_rad + self.swing_rad * np.sin(place))).as_matrix()
        rate = self.swing_rad * np.cos(place) * 2 * np.pi / self.period_s
        x, y, z = self.axis * rate
        change = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) @ rotation
        moved, moving = np.eye(4), np.zeros((4, 4))
        moved[:3, :3], moved[:3, 3] = rotation, self.pivot - rotation @ self.pivot
        moving[:3, :3], moving[:3, 3] = change, -change @ self.pivot
        return moved, moving


@attrs.frozen(eq=False)
class Skinned:
    """A skin over joints: each vertex goes where the weighted mean of its joints takes it (linear blend skinning).

    rest: (n, 3). joints: parents before children. which: (n, k) indices into joints; weights: (n, k), 0 or more, of sum 1.
    Errors: SceneError for a joint beyond the list, a parent that is not before its child, and weights that do not sum to 1.
    """

    rest: Array = attrs.field(converter=_points)
    joints: Sequence[Joint] = attrs.field(converter=tuple)
    which: NDArray[np.int64] = attrs.field(converter=lambda value: np.array(value, np.int64))
    weights: Array = attrs.field(converter=lambda value: np.array(value, np.float64))

    def __attrs_post_init__(self) -> None:
        if self.which.ndim != 2 or len(self.which) != len(self.rest) or self.weights.shape != self.which.shape:
            found = f"{len(self.rest)} points, joints {self.which.shape}, weights {self.weights.shape}"
            raise SceneError(f"skin: {found}: wanted (n, k) for both")
        self._check_joints()
        bad = ~(
            np.isfinite(self.weights).all(axis=1)
            & (self.weights >= 0).all(axis=1)
            & (np.abs(self.weights.sum(axis=1) - 1) <= 1e-4)
        )
        if bad.any():
            vertex = int(np.argmax(bad))
            raise SceneError(
                f"skin: weights {self.weights[vertex]} of vertex {vertex}: wanted 0 or more each, with sum 1"
            )

    def _check_joints(self) -> None:
        for index, joint in enumerate(self.joints):
            if not -1 <= joint.parent < index:
                raise SceneError(
                    f"joint '{joint.name}' hangs from joint {joint.parent}: wanted -1 or one before it (it is number {index})"
                )
        beyond = (self.which < 0) | (self.which >= len(self.joints))
        if beyond.any():
            vertex = int(np.argmax(beyond.any(axis=1)))
            raise SceneError(
                f"skin: vertex {vertex} wants joint {self.which[vertex].max()}, there are {len(self.joints)}"
            )

    def _blended(self, time_ns: int) -> tuple[Array, Array]:
        """(n, 3, 4) each: how vertices are moved, and the change of that in 1/s."""
        moved: list[Array] = []
        moving: list[Array] = []
        for joint in self.joints:
            turn, change = joint.turn(time_ns)
            above = (moved[joint.parent], moving[joint.parent]) if joint.parent >= 0 else (np.eye(4), np.zeros((4, 4)))
            moved.append(above[0] @ turn)
            moving.append(above[1] @ turn + above[0] @ change)
        tables = (np.array(moved)[:, :3], np.array(moving)[:, :3])
        return tuple(np.einsum("nk,nkij->nij", self.weights, table[self.which]) for table in tables)

    def _applied(self, matrices: Array) -> Array:
        return np.einsum("nij,nj->ni", matrices[:, :, :3], self.rest) + matrices[:, :, 3]

    def positions(self, time_ns: int) -> Array:
        """(n, 3) metres relative to the scene's origin."""
        return self._applied(self._blended(time_ns)[0])

    def velocities(self, time_ns: int) -> Array:
        """(n, 3) m/s in world axes."""
        return self._applied(self._blended(time_ns)[1])
