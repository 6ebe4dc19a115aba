"""Motions of rigid bodies (none, spinning, swinging, thrown, along a track), and deformations.

They are pure functions of the scene's clock, in float64.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from functools import cached_property
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base import SceneError
from ..geometry import Pose, RigidState
from .input_events import GRAB, PUSH, RELEASE, SWITCH, InputEvent, InputLog

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation, Slerp  # late where it runs: 0.3 s, and most scenes stand still


Array = NDArray[np.float64]
_GRAVITY_M_S2 = np.array([0.0, -9.81, 0.0])
# Deforming things swing: limbs and cloth return about once in SWING_S. After a latency L a swing
# has moved about as far as its speed takes it in sin(w L) / w seconds. The parabola L (1 - 2 L /
# SWING_S) lies below that curve, and is nothing from half a swing on, where the speed predicts
# nothing. Held at 0.25 s instead, the result at 800 ms was worse.
SWING_S = 2.0
REACH_S = SWING_S / 8  # the longest extrapolation
REACH_M = 0.3  # and the farthest


def swing_seconds(age_ns: int) -> float:
    """Return for how long deforming things continue with their velocity; see SWING_S."""
    age = age_ns * 1e-9
    return age * max(0.0, 1 - 2 * abs(age) / SWING_S)


def swing_m(velocities_m_s: Array, age_ns: int) -> Array:
    """Return (n, 3) how far vertices with these velocities go in `age_ns`: REACH_M at most."""
    way = velocities_m_s * swing_seconds(age_ns)
    return np.asarray(way * np.minimum(1, REACH_M / np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-20)))


def _vector(value: ArrayLike) -> Array:
    array = _array(value)
    if array.shape != (3,) or not np.isfinite(array).all():
        raise SceneError(f"motion: expected three finite numbers, found {value!r}")
    return array


def _array(value: ArrayLike) -> Array:
    return np.array(value, np.float64)


def _positive_seconds(_: object, attribute: attrs.Attribute[Any], value: float) -> None:
    if not (np.isfinite(value) and value > 0):
        raise SceneError(f"motion: {attribute.name} {value!r}: expected a time above 0")


@attrs.frozen(eq=False)
class Still:
    """No motion: a lamp that hangs, say, where something else moves."""

    at: Pose

    def state(self, time_ns: int) -> RigidState:
        return RigidState(self.at)


@attrs.frozen(eq=False)
class Spinning:
    """Endless rotation about an axis through the body's own origin. Errors: SceneError."""

    at: Pose  # world_from_body at time 0
    axis: Array = attrs.field(converter=_vector)  # in world axes, of any length
    rad_s: float = attrs.field(converter=float)  # Right-handed; negative for the other direction

    def __attrs_post_init__(self) -> None:
        if not np.isfinite(self.rad_s) or not np.linalg.norm(self.axis) > 0:
            found = f"spinning about axis {self.axis} at {self.rad_s:g} rad/s"
            raise SceneError(f"{found}: expected an axis longer than 0 and a finite speed")

    def state(self, time_ns: int) -> RigidState:
        from scipy.spatial.transform import Rotation

        spin = self.axis / np.linalg.norm(self.axis) * self.rad_s
        turned = Rotation.from_rotvec(spin * (time_ns * 1e-9)) * self.at.rotation
        return RigidState(Pose(self.at.position_m, turned.as_quat()), angular_velocity_rad_s=spin)


@attrs.frozen(eq=False)
class Pendulum:
    """Swing to and fro in a vertical plane, unturned, by a sine of time. Errors: SceneError."""

    pivot_m: Array = attrs.field(converter=_vector)
    length_m: float
    swing_rad: float  # the largest angle from straight down
    period_s: float = attrs.field(converter=float, validator=_positive_seconds)
    heading_rad: float = 0.0  # of the plane, from the x axis about +y

    def state(self, time_ns: int) -> RigidState:
        pace = 2 * np.pi / self.period_s
        angle = self.swing_rad * np.sin(pace * time_ns * 1e-9)
        speed = self.swing_rad * pace * np.cos(pace * time_ns * 1e-9)
        side = np.array([np.cos(self.heading_rad), 0, -np.sin(self.heading_rad)])
        out = np.sin(angle) * side - (0, np.cos(angle), 0)
        along = np.cos(angle) * side + (0, np.sin(angle), 0)
        pull = self.length_m * (-(pace**2) * angle * along - speed**2 * out)
        pose = Pose(self.pivot_m + self.length_m * out)
        return RigidState(pose, self.length_m * speed * along, acceleration_m_s2=pull)


@attrs.frozen(eq=False)
class Thrown:
    """Tumbling flight under gravity, repeated every `period_s`. Errors: SceneError."""

    start: Pose  # world_from_body at each throw, the first one at time 0
    velocity_m_s: Array = attrs.field(converter=_vector)
    period_s: float = attrs.field(converter=float, validator=_positive_seconds)
    # Rotation vector per second, in world axes.
    spin_rad_s: Array = attrs.field(default=(0.0, 0.0, 0.0), converter=_vector)

    def state(self, time_ns: int) -> RigidState:
        from scipy.spatial.transform import Rotation

        flown = np.mod(time_ns * 1e-9, self.period_s)
        position = self.start.position_m + flown * (self.velocity_m_s + 0.5 * flown * _GRAVITY_M_S2)
        turned = Rotation.from_rotvec(self.spin_rad_s * flown) * self.start.rotation
        velocity = self.velocity_m_s + flown * _GRAVITY_M_S2
        return RigidState(Pose(position, turned.as_quat()), velocity, self.spin_rad_s, _GRAVITY_M_S2)


@attrs.define(eq=False, frozen=True, slots=False)
class Track:
    """Spline through places at key times, turned evenly (SLERP). Errors: SceneError."""

    times_s: Array = attrs.field(converter=_array)  # (k,) increasing, at least 2 keys
    positions_m: Array = attrs.field(converter=_array)  # (k, 3)
    turns: Rotation | None = None  # (k,) SciPy rotations; None keeps the body unturned
    loops: bool = True  # starts again after the last key, where it begins; else stands still

    def __attrs_post_init__(self) -> None:
        times, places = self.times_s, self.positions_m
        if times.ndim != 1 or len(times) < 2 or places.shape != (len(times), 3):
            found = f"track: {times.shape} key times and {places.shape} positions"
            raise SceneError(f"{found}: expected (k,) and (k, 3), 2 keys at least")
        if (bad := ~(np.isfinite(times) & np.isfinite(places).all(axis=1))).any():
            raise SceneError(f"track: key {int(np.argmax(bad))} is not made of finite numbers")
        if (backwards := np.diff(times) <= 0).any():
            key = int(np.argmax(backwards)) + 1
            found = f"track: key {key} is at {times[key]:g} s, the one before at {times[key - 1]:g} s"
            raise SceneError(f"{found}: key times must increase")
        if self.turns is not None and len(self.turns) != len(times):
            raise SceneError(f"track: {len(times)} key times and {len(self.turns)} turns: expected as many")
        apart = np.abs(self.positions_m[-1] - self.positions_m[0]).max()
        apart = max(apart, 0 if self.turns is None else (self.turns[0].inv() * self.turns[-1]).magnitude())
        if self.loops and not apart <= 1e-6:
            raise SceneError("track: the last key of a loop must be the pose of the first, within 1 um and 1 urad")

    @cached_property
    def _path(self) -> Any:
        from scipy.interpolate import CubicSpline

        places = self.positions_m
        if self.loops:
            places = np.concatenate([places[:-1], places[:1]])  # SciPy demands a period closed to the last bit
        return CubicSpline(self.times_s, places, bc_type="periodic" if self.loops else "natural")

    @cached_property
    def _turning(self) -> Slerp | None:
        from scipy.spatial.transform import Slerp

        return None if self.turns is None else Slerp(self.times_s, self.turns)

    def state(self, time_ns: int) -> RigidState:
        from scipy.spatial.transform import Rotation

        first, last = self.times_s[0], self.times_s[-1]
        seconds = time_ns * 1e-9
        at = first + np.mod(seconds - first, last - first) if self.loops else np.clip(seconds, first, last)
        turn = self._turning(at) if self._turning is not None else Rotation.identity()
        pose = Pose(self._path(at), turn.as_quat())
        if not self.loops and not first < seconds < last:
            return RigidState(pose)
        spin = np.zeros(3)
        if self.turns is not None:
            key = int(np.clip(np.searchsorted(self.times_s, at, side="right") - 1, 0, len(self.times_s) - 2))
            turned = (self.turns[key + 1] * self.turns[key].inv()).as_rotvec()
            spin = turned / (self.times_s[key + 1] - self.times_s[key])
        return RigidState(pose, self._path(at, 1), spin, self._path(at, 2))


def _points(value: ArrayLike) -> Array:
    array = _array(value)
    if array.ndim != 2 or array.shape[1] != 3 or not np.isfinite(array).all():
        raise SceneError(f"deformation: expected (n, 3) finite numbers, found shape {array.shape}, or not all finite")
    return array


def _direction(value: ArrayLike) -> Array:
    array = _array(value)
    if array.shape != (3,) or not np.isfinite(array).all() or not np.linalg.norm(array) > 0:
        raise SceneError(f"deformation: expected a direction of three finite numbers longer than 0, found {value!r}")
    return array / np.linalg.norm(array)


@attrs.frozen(eq=False)
class Waving:
    """Cloth held along one edge; waves run out and grow with the distance. Errors: SceneError."""

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
        sizes = [self.height_m, self.length_m, self.period_s]
        if not (self.length_m > 0 and self.period_s > 0 and np.isfinite(sizes).all()):
            raise SceneError(f"waving: length {self.length_m:g} m, period {self.period_s:g} s: expected both above 0")

    def _swing(self, time_ns: int, quarter: int) -> Array:
        phase = time_ns * 1e-9 / self.period_s - self.away / self.length_m - self.lag + 0.25 * quarter
        return np.sin(2 * np.pi * phase)

    def positions(self, time_ns: int) -> Array:
        return self.rest + (self.height_m * self.away * self._swing(time_ns, 0))[:, None] * self.out

    def velocities(self, time_ns: int) -> Array:
        speed = 2 * np.pi / self.period_s * self.height_m * self.away * self._swing(time_ns, 1)
        return speed[:, None] * self.out


State = TypeVar("State")
FOLLOWS = 12.0  # 1/s: how fast what is grabbed follows the hand
_UP = np.array([0.0, 1.0, 0.0])


class Reacting(ABC, Generic[State]):
    """A thing whose state follows from the inputs that name it."""

    takes: tuple[str, ...]

    def __init__(self, name: str, log: InputLog, rest: State) -> None:
        self.name, self._log, self._rest = name, log, rest
        log.things[name] = self

    def at(self, time_ns: int) -> State:
        """Return its state at an instant, by the inputs up to then."""
        events, count = self._log.of(self.name, time_ns)
        states: list[State] = self._log.book.states[self.name]
        if not states:
            states.append(self._rest)
        for number in range(len(states) - 1, count):
            states.append(self.changed(self._since(number, events[number].time_ns), events[number]))
        return self._since(count, time_ns)

    def _since(self, number: int, time_ns: int) -> State:
        book = self._log.book
        state: State = book.states[self.name][number]
        if not number:
            return state
        return self.after(state, (time_ns - book.events[self.name][number - 1].time_ns) * 1e-9)

    @abstractmethod
    def after(self, state: State, seconds: float) -> State:
        """Return what a state becomes without further inputs."""

    @abstractmethod
    def changed(self, state: State, event: InputEvent) -> State:
        """Return what an input makes of a state."""

    @abstractmethod
    def handle(self, time_ns: int) -> Array:
        """Return the (3,) place in the world that a hand aims at."""


@attrs.frozen(eq=False)
class _BallState:
    """A ball at an instant: held, in flight, or on the floor."""

    position_m: Array
    velocity_m_s: Array
    turn: Array  # quaternion, xyzw
    spin_rad_s: Array
    flies: bool = False
    hand_m: Array | None = None  # where the hand holds it; None while it is free
    reach_m: float = 0.0  # how far from the hand's origin that is


class Bouncing(Reacting[_BallState]):
    """A ball in a room, which it meets at the floor, the walls and the ceiling alone."""

    takes = (PUSH, GRAB, RELEASE)
    RESTITUTION, REST_M_S, ROLLS_M_S2 = 0.75, 0.35, 0.8  # slower than REST_M_S upwards it stays down
    PUSH_M_S, LIFT_M_S, FASTEST_M_S = 1.2, 3.0, 8.0

    def __init__(self, name: str, log: InputLog, at_m: ArrayLike, radius_m: float, room_m: ArrayLike) -> None:
        """Place a ball. at_m: x and z. room_m: (2, 3) lowest and highest corner of the room."""
        low, high = np.array(room_m, np.float64)
        self.radius_m, self._low, self._high = radius_m, low + radius_m, high - radius_m
        x, z = np.array(at_m, np.float64)
        place = np.array([x, self._low[1], z])
        super().__init__(name, log, _BallState(place, np.zeros(3), np.array([0.0, 0, 0, 1]), np.zeros(3)))

    def handle(self, time_ns: int) -> Array:
        return self.at(time_ns).position_m

    def state(self, time_ns: int) -> RigidState:
        now = self.at(time_ns)
        pose = Pose(now.position_m, now.turn)
        return RigidState(pose, now.velocity_m_s, now.spin_rad_s, self._acceleration(now))

    def _acceleration(self, now: _BallState) -> Array:
        if now.hand_m is not None:
            return FOLLOWS**2 * (now.position_m - now.hand_m)
        if now.flies:
            return _GRAVITY_M_S2
        speed = float(np.linalg.norm(now.velocity_m_s))
        return -self.ROLLS_M_S2 / speed * now.velocity_m_s if speed else np.zeros(3)

    def changed(self, state: _BallState, event: InputEvent) -> _BallState:
        ray = np.array(event.direction) / np.linalg.norm(event.direction)
        if event.action == PUSH:
            speed = state.velocity_m_s + self.PUSH_M_S * ray + self.LIFT_M_S * _UP
            return attrs.evolve(state, velocity_m_s=self._limited(speed), flies=True, hand_m=None)
        if event.action == RELEASE:
            return attrs.evolve(state, velocity_m_s=self._limited(state.velocity_m_s), flies=True, hand_m=None)
        held = state.hand_m is not None
        reach = state.reach_m if held else float(np.linalg.norm(state.position_m - event.origin_m))
        hand = np.clip(event.origin_m + reach * ray, self._low, self._high)
        moves = FOLLOWS * (hand - state.position_m)
        return attrs.evolve(state, hand_m=hand, reach_m=reach, velocity_m_s=moves, spin_rad_s=np.zeros(3))

    def _limited(self, velocity: Array) -> Array:
        return velocity * min(1.0, self.FASTEST_M_S / max(float(np.linalg.norm(velocity)), 1e-9))

    def after(self, state: _BallState, seconds: float) -> _BallState:
        if state.hand_m is not None:
            way = (state.position_m - state.hand_m) * math.exp(-FOLLOWS * seconds)
            return attrs.evolve(state, position_m=state.hand_m + way, velocity_m_s=-FOLLOWS * way)
        while seconds > 0 and (state.flies or state.velocity_m_s.any()):
            state, took = self._to_next(state, seconds)
            seconds -= took
        return state

    def _to_next(self, state: _BallState, seconds: float) -> tuple[_BallState, float]:
        """Return the state after a bounce, or so many seconds, and how long it took."""
        pull = self._acceleration(state)
        ends = float(np.linalg.norm(state.velocity_m_s)) / self.ROLLS_M_S2 if not state.flies else math.inf
        bounds = [(k, side, at[k]) for side, at in ((-1, self._low), (1, self._high)) for k in range(3)]
        when, axis, bound = min(
            (_meets(state.position_m[k] - at, state.velocity_m_s[k], pull[k], side), k, at)
            for k, side, at in bounds
            if state.flies or k != 1
        )
        took = min(when, ends, seconds)
        place = state.position_m + took * (state.velocity_m_s + 0.5 * took * pull)
        speed = state.velocity_m_s + took * pull
        moved = attrs.evolve(state, position_m=place, velocity_m_s=speed, turn=_turned(state, took))
        if took == ends:
            return attrs.evolve(moved, velocity_m_s=np.zeros(3), spin_rad_s=np.zeros(3)), took
        return (self._bounced(moved, axis, bound) if took == when else moved), took

    def _bounced(self, state: _BallState, axis: int, bound: float) -> _BallState:
        place, speed = state.position_m.copy(), state.velocity_m_s.copy()
        place[axis], speed[axis] = bound, -self.RESTITUTION * speed[axis]
        on_floor = axis == 1 and bound == self._low[1]
        rests = on_floor and speed[1] < self.REST_M_S
        if rests:
            speed[1] = 0.0
        spin = np.cross(_UP, speed) / self.radius_m if on_floor or not state.flies else state.spin_rad_s
        flies = state.flies and not rests
        return attrs.evolve(state, position_m=place, velocity_m_s=speed, spin_rad_s=spin, flies=flies)


def _meets(beyond: float, speed: float, pull: float, side: int) -> float:
    """Return the seconds until a way beyond + speed t + pull t^2 / 2 leaves 0 to that side."""
    if beyond * side >= 0 and (speed * side > 0 or (speed == 0 and pull * side > 0)):
        return 0.0
    if pull == 0:
        return -beyond / speed if speed * side > 0 else math.inf
    under = speed * speed - 2 * pull * beyond
    if under < 0:
        return math.inf
    root = math.sqrt(under)
    # At this root its speed is side * root: outwards.
    when = (side * root - speed) / pull
    return when if when > 0 and root > 0 else math.inf


def _turned(state: _BallState, seconds: float) -> Array:
    from scipy.spatial.transform import Rotation

    if not state.spin_rad_s.any():
        return state.turn
    turned = Rotation.from_rotvec(state.spin_rad_s * seconds) * Rotation.from_quat(state.turn)
    return np.asarray(turned.as_quat())


@attrs.frozen
class _DoorState:
    """A door at an instant."""

    angle_rad: float = 0.0
    rad_s: float = 0.0
    hand_rad: float | None = None  # where the hand would have it; None while it is free
    reach_m: float = 0.0  # how far the hand is from its origin


class Hinged(Reacting[_DoorState]):
    """A door that a push throws open or shut, and that follows a hand; friction stops it.

    Its own axes begin at the hinge, +x along the leaf; it opens from +x towards +z.
    """

    takes = (PUSH, GRAB, RELEASE)
    PUSH_RAD_S, FRICTION, WIDEST_RAD = 4.5, 2.0, 1.9

    def __init__(self, name: str, log: InputLog, hinge_m: ArrayLike, grip_m: ArrayLike) -> None:
        """Hang a door. hinge_m: in the world. grip_m: of the handle, in the door's own axes."""
        self._hinge, self._grip = np.array(hinge_m, np.float64), np.array(grip_m, np.float64)
        super().__init__(name, log, _DoorState())

    def handle(self, time_ns: int) -> Array:
        return self._pose(self.at(time_ns)).transform(self._grip)

    def state(self, time_ns: int) -> RigidState:
        now = self.at(time_ns)
        return RigidState(self._pose(now), angular_velocity_rad_s=-now.rad_s * _UP)

    def _pose(self, state: _DoorState) -> Pose:
        half = -state.angle_rad / 2
        return Pose(self._hinge, (0.0, math.sin(half), 0.0, math.cos(half)))

    def after(self, state: _DoorState, seconds: float) -> _DoorState:
        if state.hand_rad is not None:
            left = (state.angle_rad - state.hand_rad) * math.exp(-FOLLOWS * seconds)
            return attrs.evolve(state, angle_rad=state.hand_rad + left, rad_s=-FOLLOWS * left)
        slows = math.exp(-self.FRICTION * seconds)
        angle = state.angle_rad + state.rad_s * (1 - slows) / self.FRICTION
        stops = min(max(angle, 0.0), self.WIDEST_RAD)
        return attrs.evolve(state, angle_rad=stops, rad_s=state.rad_s * slows if stops == angle else 0.0)

    def changed(self, state: _DoorState, event: InputEvent) -> _DoorState:
        if event.action == PUSH:
            opens = state.angle_rad < self.WIDEST_RAD / 2
            return _DoorState(state.angle_rad, self.PUSH_RAD_S if opens else -self.PUSH_RAD_S)
        if event.action == RELEASE:
            return _DoorState(state.angle_rad, state.rad_s)
        ray = np.array(event.direction) / np.linalg.norm(event.direction)
        reach = state.reach_m
        if state.hand_rad is None:
            reach = float(np.linalg.norm(self._pose(state).transform(self._grip) - event.origin_m))
        x, _, z = event.origin_m + reach * ray - self._hinge
        hand = min(max(math.atan2(z, x), 0.0), self.WIDEST_RAD)
        return _DoorState(state.angle_rad, FOLLOWS * (hand - state.angle_rad), hand, reach)


class Switched(Reacting[bool]):
    """The share of its light that a lamp sends: all or nothing, changed by its switch.

    A push is the same, so that a client which only pushes need not know what is near.
    """

    takes = (SWITCH, PUSH)

    def __init__(self, name: str, log: InputLog, switch_m: ArrayLike, *, on: bool = True) -> None:
        """Wire a lamp. switch_m: place of the switch in the world."""
        self._place = np.array(switch_m, np.float64)
        super().__init__(name, log, on)

    def handle(self, time_ns: int) -> Array:
        return self._place

    def share(self, time_ns: int) -> float:
        return float(self.at(time_ns))

    def after(self, state: bool, seconds: float) -> bool:
        return state

    def changed(self, state: bool, event: InputEvent) -> bool:
        return not state
