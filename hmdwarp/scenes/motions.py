"""How rigid bodies move: spinning, along a track, thrown. Each is a pure function of the scene's clock, in float64."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation, Slerp

from ..errors import SceneError
from ..geometry import Pose, RigidState

Array = NDArray[np.float64]
GRAVITY_M_S2 = (0.0, -9.81, 0.0)


def _vector(value: ArrayLike) -> Array:
    array = np.array(value, np.float64)
    if array.shape != (3,) or not np.isfinite(array).all():
        raise SceneError(f"motion: wanted three finite numbers, found {value!r}")
    return array


def _positive_seconds(_: object, attribute: attrs.Attribute, value: float) -> None:
    if not (np.isfinite(value) and value > 0):
        raise SceneError(f"motion: {attribute.name} {value!r}: wanted a time above 0")


@attrs.frozen(eq=False)
class Spinning:
    """Turns for ever about an axis through its own origin.

    at: world_from_body at time 0. axis: in world axes, any length. rad_s: right-handed, negative for the other way round.
    Errors: SceneError for an axis of length 0 and for numbers that are not finite.
    """

    at: Pose
    axis: Array = attrs.field(converter=_vector)
    rad_s: float = attrs.field(converter=float)

    def __attrs_post_init__(self) -> None:
        if not np.isfinite(self.rad_s) or not np.linalg.norm(self.axis) > 0:
            raise SceneError(
                f"spinning about axis {self.axis} at {self.rad_s:g} rad/s: wanted an axis longer than 0 and a finite speed"
            )

    def state(self, time_ns: int) -> RigidState:
        """Where it is then, and how it moves."""
        spin = self.axis / np.linalg.norm(self.axis) * self.rad_s
        turned = Rotation.from_rotvec(spin * (time_ns * 1e-9)) * self.at.rotation
        return RigidState(Pose(self.at.position_m, turned.as_quat()), angular_velocity_rad_s=spin)


@attrs.frozen(eq=False)
class Thrown:
    """Flies under gravity from where it is thrown, tumbling, and is thrown again every `period_s`.

    start: world_from_body when it is thrown, at time 0 first. velocity_m_s then; spin_rad_s: a rotation vector a second, in world axes.
    Errors: SceneError for a period that is not above 0 and for numbers that are not finite.
    """

    start: Pose
    velocity_m_s: Array = attrs.field(converter=_vector)
    period_s: float = attrs.field(converter=float, validator=_positive_seconds)
    spin_rad_s: Array = attrs.field(default=(0.0, 0.0, 0.0), converter=_vector)
    gravity_m_s2: Array = attrs.field(default=GRAVITY_M_S2, converter=_vector)

    def state(self, time_ns: int) -> RigidState:
        """Where it is then, and how it moves."""
        flown = np.mod(time_ns * 1e-9, self.period_s)
        position = self.start.position_m + flown * (self.velocity_m_s + 0.5 * flown * self.gravity_m_s2)
        turned = Rotation.from_rotvec(self.spin_rad_s * flown) * self.start.rotation
        velocity = self.velocity_m_s + flown * self.gravity_m_s2
        return RigidState(Pose(position, turned.as_quat()), velocity, self.spin_rad_s, self.gravity_m_s2)


@attrs.define(eq=False, frozen=True, slots=False)
class Track:
    """Through key poses at key times: positions on a cubic spline, or evenly from each to the next, as orientations always are.

    times_s: (k,) increasing, 2 keys at least. positions_m: (k, 3). turns: (k,) SciPy rotations, None to stay unturned. loops: it
    begins anew after the last key, which a spline wants to be the first again; else it stands still before the first and after the last.
    smooth: on the spline.
    Errors: SceneError for key times that do not increase, numbers that are not finite, counts that differ, and a loop that does not close.
    """

    times_s: Array = attrs.field(converter=lambda value: np.array(value, np.float64))
    positions_m: Array = attrs.field(converter=lambda value: np.array(value, np.float64))
    turns: Rotation | None = None
    loops: bool = True
    smooth: bool = True

    def __attrs_post_init__(self) -> None:
        times, places = self.times_s, self.positions_m
        if times.ndim != 1 or len(times) < 2 or places.shape != (len(times), 3):
            raise SceneError(
                f"track: {times.shape} key times and {places.shape} positions: wanted (k,) and (k, 3), 2 keys at least"
            )
        bad = ~(np.isfinite(times) & np.isfinite(places).all(axis=1))
        if bad.any():
            raise SceneError(f"track: key {int(np.argmax(bad))} is not made of finite numbers")
        rendered = np.diff(times) <= 0
        if rendered.any():
            key = int(np.argmax(rendered)) + 1
            raise SceneError(
                f"track: key {key} is at {times[key]:g} s, the one before at {times[key - 1]:g} s: key times must increase"
            )
        if self.turns is not None and len(self.turns) != len(times):
            raise SceneError(f"track: {len(times)} key times and {len(self.turns)} turns: wanted as many")
        if self.loops and self.smooth and not self._closes():
            raise SceneError(
                "track: the last key of a loop must be the pose of the first, give or take 1 um and 1 urad"
            )

    def _closes(self) -> bool:
        apart = np.abs(self.positions_m[-1] - self.positions_m[0]).max()
        return apart <= 1e-6 and (self.turns is None or (self.turns[0].inv() * self.turns[-1]).magnitude() <= 1e-6)

    @cached_property
    def _path(self) -> Callable[..., Array]:
        """Position at a time in s, and with a second argument its derivatives."""
        from scipy.interpolate import CubicSpline, PPoly

        if not self.smooth:
            steps = np.diff(self.positions_m, axis=0) / np.diff(self.times_s)[:, None]
            return PPoly(np.stack([steps, self.positions_m[:-1]]), self.times_s)
        places = self.positions_m
        if self.loops:
            places = np.concatenate([places[:-1], places[:1]])  # SciPy wants a period to close to the last bit
        return CubicSpline(self.times_s, places, bc_type="periodic" if self.loops else "natural")

    @cached_property
    def _turning(self) -> Slerp | None:
        return None if self.turns is None else Slerp(self.times_s, self.turns)

    def state(self, time_ns: int) -> RigidState:
        """Where it is then, and how it moves."""
        first, last = self.times_s[0], self.times_s[-1]
        seconds = time_ns * 1e-9
        at = first + np.mod(seconds - first, last - first) if self.loops else np.clip(seconds, first, last)
        turn = self._turning(at) if self._turning is not None else Rotation.identity()
        pose = Pose(self._path(at), turn.as_quat())
        if not self.loops and not first < seconds < last:
            return RigidState(pose)
        return RigidState(pose, self._path(at, 1), self._spin(at), self._path(at, 2))

    def _spin(self, at: float) -> Array:
        if self.turns is None:
            return np.zeros(3)
        key = int(np.clip(np.searchsorted(self.times_s, at, side="right") - 1, 0, len(self.times_s) - 2))
        between = self.turns[key + 1] * self.turns[key].inv()
        return between.as_rotvec() / (self.times_s[key + 1] - self.times_s[key])
