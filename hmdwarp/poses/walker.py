"""A head moved by mouse and keys: the mouse turns it, the keys walk it.

Depends on no window and reads no clock.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections import deque

import attrs

from ..geometry import Pose
from .track import Origin, PoseSample

EYE_HEIGHT_M = 1.6
WALK_M_S, FASTER = 1.4, 3.0  # a pedestrian's pace (Browning et al. 2006 measured 1.4 m/s); with shift, a run
STEEPEST_RAD = math.radians(89.0)
# Time constants of turning and walking. 20 ms: the steps of a mouse that is read at 60 Hz become a
# smooth turn; more would be noticeable. 80 ms: a step's start and stop.
TURN_S, WALK_S = 0.020, 0.080
HORIZON_NS = 50_000_000
GRID_NS = 4_000_000
KEPT_NS = 250_000_000
# No input for this long means that the program was suspended, or busy with a new scene.
DEAF_NS = 1_000_000_000
STILL_M_S, STILL_RAD = 1e-6, 1e-9


@attrs.define(eq=False)
class _State:
    """State of the head and its last input at `time_ns`."""

    time_ns: int
    position: tuple[float, float, float]
    velocity: tuple[float, float, float]
    yaw: float
    pitch: float
    yaw_goal: float
    pitch_goal: float
    wish: tuple[float, float, float]  # m/s to the right, up and forward of the gaze

    @property
    def at_rest(self) -> bool:
        turned = self.yaw == self.yaw_goal and self.pitch == self.pitch_goal
        return turned and not any(self.wish) and not any(self.velocity)

    def after(self, time_ns: int) -> _State:
        """Return the state without further input: first-order lags, exact, heading at its mean."""
        seconds = (time_ns - self.time_ns) * 1e-9
        turned, half = math.exp(-seconds / TURN_S), math.exp(-seconds / (2 * TURN_S))
        slowed = math.exp(-seconds / WALK_S)
        heading = self.yaw_goal + (self.yaw - self.yaw_goal) * half
        sine, cosine, (right, uy, forward) = math.sin(heading), math.cos(heading), self.wish
        ux, uz = right * cosine - forward * sine, -right * sine - forward * cosine
        (x, y, z), (vx, vy, vz) = self.position, self.velocity
        velocity = ux + (vx - ux) * slowed, uy + (vy - uy) * slowed, uz + (vz - uz) * slowed

        def moved(x: float, v: float, u: float) -> float:
            return x + u * seconds + (v - u) * WALK_S * (1 - slowed)

        position = moved(x, vx, ux), moved(y, vy, uy), moved(z, vz, uz)
        yaw = self.yaw_goal + (self.yaw - self.yaw_goal) * turned
        pitch = self.pitch_goal + (self.pitch - self.pitch_goal) * turned
        return _State(time_ns, position, velocity, yaw, pitch, self.yaw_goal, self.pitch_goal, self.wish)

    def settled(self) -> _State:
        """Zero out residual motion, which an exponential never loses."""
        if not any(self.wish) and max(map(abs, self.velocity)) < STILL_M_S:
            self.velocity = (0.0, 0.0, 0.0)
        if max(abs(self.yaw - self.yaw_goal), abs(self.pitch - self.pitch_goal)) < STILL_RAD:
            self.yaw, self.pitch = self.yaw_goal, self.pitch_goal
        return self

    def pose(self) -> Pose:
        (sy, cy), (sp, cp) = ((math.sin(angle / 2), math.cos(angle / 2)) for angle in (self.yaw, self.pitch))
        # About the world's y after the head's x: never any roll.
        return Pose(self.position, (cy * sp, sy * cp, -sy * sp, cy * cp))


class Walker:
    """A head at eye height that turns and walks smoothly on command.

    Every input has its time; `advance` says that no more came until then. The path is a function of
    these alone, bit for bit: it is computed on a grid of its own, however often it is sampled.
    Angles: yaw to the left, pitch up, radians; pitch within 89 degrees. Times must not run
    backwards: an earlier one counts as the latest known.
    """

    def __init__(self, time_ns: int) -> None:
        self._now_ns, self._recentred = time_ns, 0
        self._states: deque[_State] = deque()
        self._place(time_ns)

    def turn(self, time_ns: int, yaw_rad: float, pitch_rad: float) -> None:
        """Turn this much further to the left and up."""
        state = self._state_for_input(time_ns)
        state.yaw_goal += yaw_rad
        state.pitch_goal = min(max(state.pitch_goal + pitch_rad, -STEEPEST_RAD), STEEPEST_RAD)

    def walk(
        self, time_ns: int, right: float = 0.0, up: float = 0.0, forward: float = 0.0, *, fast: bool = False
    ) -> None:
        """Walk in this direction from now on, -1..1 each, level with the ground whatever the pitch.

        Zeros stop.
        """
        length = max(1.0, math.hypot(right, forward))
        pace = WALK_M_S * (FASTER if fast else 1.0)
        wish = (pace * right / length, pace * up, pace * forward / length)
        self.advance(time_ns)
        if wish != self._states[-1].wish:
            self._state_for_input(time_ns).wish = wish

    def recentre(self, time_ns: int) -> None:
        """Jump back to the start, looking ahead; walking continues."""
        wish = self._states[-1].wish
        self._now_ns = max(time_ns, self._now_ns)
        self._recentred += 1
        self._states.clear()
        self._place(self._now_ns)
        self._states[-1].wish = wish

    def advance(self, now_ns: int) -> None:
        """Note that there was no input until now."""
        if now_ns - self._now_ns > DEAF_NS:
            self._state_for_input(self._now_ns).wish = (0.0, 0.0, 0.0)
        self._now_ns = max(now_ns, self._now_ns)
        last = self._states[-1]
        while not last.at_rest and (tick_ns := (last.time_ns // GRID_NS + 1) * GRID_NS) <= self._now_ns:
            last = last.after(tick_ns).settled()
            self._states.append(last)
        while len(self._states) > 1 and self._states[1].time_ns < self._now_ns - KEPT_NS:
            self._states.popleft()

    def head_at(self, time_ns: int) -> PoseSample:
        """Return world_from_head, exact for the last quarter of a second (HELD before that).

        The future is PREDICTED as if no input came, for 50 ms at most: turning and walking continue
        with their lags, so the head never overshoots when the hand stops.
        """
        if time_ns > self._now_ns:
            state, origin = self._known(self._now_ns).after(min(time_ns, self._now_ns + HORIZON_NS)), Origin.PREDICTED
        elif time_ns < self._states[0].time_ns:
            state, origin = self._states[0], Origin.HELD
        else:
            state, origin = self._known(time_ns), Origin.INTERPOLATED
            origin = Origin.MEASURED if time_ns == self._now_ns else origin
        return PoseSample(time_ns, state.pose(), origin, read_ns=self._now_ns, space=self._recentred)

    def _known(self, time_ns: int) -> _State:
        return self._states[bisect_right(self._states, time_ns, key=lambda state: state.time_ns) - 1].after(time_ns)

    def _state_for_input(self, time_ns: int) -> _State:
        """Return the state at that instant, for its input to be changed."""
        if time_ns > self._now_ns:
            self.advance(time_ns)
        self._states.append(self._states[-1].after(self._now_ns))
        return self._states[-1]

    def _place(self, time_ns: int) -> None:
        still = (0.0, 0.0, 0.0)
        self._states.append(_State(time_ns, (0.0, EYE_HEIGHT_M, 0.0), still, 0.0, 0.0, 0.0, 0.0, still))
