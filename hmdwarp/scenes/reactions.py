"""Things that react to what people do: a ball, a door on a hinge, a lamp with a switch.

Between two inputs each goes on by a closed form; an input changes how. States depend on times since
inputs alone, so that a clock that begins elsewhere gives the same bits.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import Generic, TypeVar

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..geometry import Pose, RigidState
from .input_events import GRAB, PUSH, RELEASE, SWITCH, InputEvent, InputLog
from .motions import GRAVITY_M_S2

Array = NDArray[np.float64]
State = TypeVar("State")
# 1/s: how fast what is grabbed follows the hand.
FOLLOWS = 12.0
_UP = np.array([0.0, 1.0, 0.0])


class Reacting(ABC, Generic[State]):
    """A thing whose state follows from the inputs that name it."""

    takes: tuple[str, ...]

    def __init__(self, name: str, log: InputLog, rest: State) -> None:
        self.name, self._log, self._rest = name, log, rest
        log.react(self)

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
        """Return the state at an instant after so many inputs."""
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
class BallState:
    """A ball at an instant: held, in flight, or on the floor."""

    position_m: Array
    velocity_m_s: Array
    turn: Array  # quaternion, xyzw
    spin_rad_s: Array
    flies: bool = False
    # Where the hand holds it, and how far from the hand's origin that is; None while it is free.
    hand_m: Array | None = None
    reach_m: float = 0.0


class Bouncing(Reacting[BallState]):
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
        super().__init__(name, log, BallState(place, np.zeros(3), np.array([0.0, 0, 0, 1]), np.zeros(3)))

    def handle(self, time_ns: int) -> Array:
        return self.at(time_ns).position_m

    def state(self, time_ns: int) -> RigidState:
        """Return the pose and its derivatives at `time_ns`."""
        now = self.at(time_ns)
        pose = Pose(now.position_m, now.turn)
        return RigidState(pose, now.velocity_m_s, now.spin_rad_s, self._acceleration(now))

    def _acceleration(self, now: BallState) -> Array:
        if now.hand_m is not None:
            return FOLLOWS**2 * (now.position_m - now.hand_m)
        if now.flies:
            return np.array(GRAVITY_M_S2)
        speed = float(np.linalg.norm(now.velocity_m_s))
        return -self.ROLLS_M_S2 / speed * now.velocity_m_s if speed else np.zeros(3)

    def changed(self, state: BallState, event: InputEvent) -> BallState:
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

    def after(self, state: BallState, seconds: float) -> BallState:
        if state.hand_m is not None:
            way = (state.position_m - state.hand_m) * math.exp(-FOLLOWS * seconds)
            return attrs.evolve(state, position_m=state.hand_m + way, velocity_m_s=-FOLLOWS * way)
        while seconds > 0 and (state.flies or state.velocity_m_s.any()):
            state, took = self._to_next(state, seconds)
            seconds -= took
        return state

    def _to_next(self, state: BallState, seconds: float) -> tuple[BallState, float]:
        """Return the state after a bounce, or so many seconds, and how long it took."""
        pull = self._acceleration(state)
        ends = float(np.linalg.norm(state.velocity_m_s)) / self.ROLLS_M_S2 if not state.flies else math.inf
        meets = [
            (_meets(state.position_m[k] - bound, state.velocity_m_s[k], pull[k], side), k, bound)
            for side, bounds in ((-1, self._low), (1, self._high))
            for k, bound in enumerate(bounds)
            if state.flies or k != 1
        ]
        when, axis, bound = min(meets)
        took = min(when, ends, seconds)
        place = state.position_m + took * (state.velocity_m_s + 0.5 * took * pull)
        speed = state.velocity_m_s + took * pull
        moved = attrs.evolve(state, position_m=place, velocity_m_s=speed, turn=_turned(state, took))
        if took == ends:
            return attrs.evolve(moved, velocity_m_s=np.zeros(3), spin_rad_s=np.zeros(3)), took
        return (self._bounced(moved, axis, bound) if took == when else moved), took

    def _bounced(self, state: BallState, axis: int, bound: float) -> BallState:
        place, speed = state.position_m.copy(), state.velocity_m_s.copy()
        place[axis] = bound
        speed[axis] *= -self.RESTITUTION
        on_floor = axis == 1 and bound == self._low[1]
        rests = on_floor and speed[1] < self.REST_M_S
        if rests:
            speed[1] = 0.0
        rolls = on_floor or not state.flies
        spin = np.cross(_UP, speed) / self.radius_m if rolls else state.spin_rad_s
        return attrs.evolve(
            state, position_m=place, velocity_m_s=speed, spin_rad_s=spin, flies=state.flies and not rests
        )


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


def _turned(state: BallState, seconds: float) -> Array:
    from scipy.spatial.transform import Rotation

    if not state.spin_rad_s.any():
        return state.turn
    turned = Rotation.from_rotvec(state.spin_rad_s * seconds) * Rotation.from_quat(state.turn)
    return np.asarray(turned.as_quat())


@attrs.frozen
class DoorState:
    """A door at an instant."""

    angle_rad: float = 0.0
    rad_s: float = 0.0
    # Where the hand would have it, and how far the hand is from its origin; None while it is free.
    hand_rad: float | None = None
    reach_m: float = 0.0


class Hinged(Reacting[DoorState]):
    """A door that a push throws open or shut, and that follows a hand; friction brings it to rest.

    Its own axes begin at the hinge, +x along the leaf; it opens from +x towards +z.
    """

    takes = (PUSH, GRAB, RELEASE)
    PUSH_RAD_S, FRICTION, WIDEST_RAD = 4.5, 2.0, 1.9

    def __init__(self, name: str, log: InputLog, hinge_m: ArrayLike, grip_m: ArrayLike) -> None:
        """Hang a door. hinge_m: in the world. grip_m: of the handle, in the door's own axes."""
        self._hinge, self._grip = np.array(hinge_m, np.float64), np.array(grip_m, np.float64)
        super().__init__(name, log, DoorState())

    def handle(self, time_ns: int) -> Array:
        return self._pose(self.at(time_ns)).transform(self._grip)

    def state(self, time_ns: int) -> RigidState:
        """Return the pose and its derivatives at `time_ns`."""
        now = self.at(time_ns)
        return RigidState(self._pose(now), angular_velocity_rad_s=-now.rad_s * _UP)

    def _pose(self, state: DoorState) -> Pose:
        half = -state.angle_rad / 2
        return Pose(self._hinge, (0.0, math.sin(half), 0.0, math.cos(half)))

    def after(self, state: DoorState, seconds: float) -> DoorState:
        if state.hand_rad is not None:
            left = (state.angle_rad - state.hand_rad) * math.exp(-FOLLOWS * seconds)
            return attrs.evolve(state, angle_rad=state.hand_rad + left, rad_s=-FOLLOWS * left)
        slows = math.exp(-self.FRICTION * seconds)
        angle = state.angle_rad + state.rad_s * (1 - slows) / self.FRICTION
        stops = min(max(angle, 0.0), self.WIDEST_RAD)
        return attrs.evolve(state, angle_rad=stops, rad_s=state.rad_s * slows if stops == angle else 0.0)

    def changed(self, state: DoorState, event: InputEvent) -> DoorState:
        if event.action == PUSH:
            opens = state.angle_rad < self.WIDEST_RAD / 2
            return DoorState(state.angle_rad, self.PUSH_RAD_S if opens else -self.PUSH_RAD_S)
        if event.action == RELEASE:
            return DoorState(state.angle_rad, state.rad_s)
        ray = np.array(event.direction) / np.linalg.norm(event.direction)
        reach = state.reach_m
        if state.hand_rad is None:
            reach = float(np.linalg.norm(self._pose(state).transform(self._grip) - event.origin_m))
        x, _, z = event.origin_m + reach * ray - self._hinge
        hand = min(max(math.atan2(z, x), 0.0), self.WIDEST_RAD)
        return DoorState(state.angle_rad, FOLLOWS * (hand - state.angle_rad), hand, reach)


class Switched(Reacting[bool]):
    """The share of its light that a lamp sends: all or nothing, changed by its switch.

    A push of the switch is the same, so that a client which only pushes need not know what is near.
    """

    takes = (SWITCH, PUSH)

    def __init__(self, name: str, log: InputLog, switch_m: ArrayLike, *, on: bool = True) -> None:
        """Wire a lamp. switch_m: place of the switch in the world."""
        self._place = np.array(switch_m, np.float64)
        super().__init__(name, log, on)

    def handle(self, time_ns: int) -> Array:
        return self._place

    def share(self, time_ns: int) -> float:
        """Return 1 while it is on, else 0."""
        return float(self.at(time_ns))

    def after(self, state: bool, seconds: float) -> bool:
        return state

    def changed(self, state: bool, event: InputEvent) -> bool:
        return not state
