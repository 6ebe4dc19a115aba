"""Synthetic heads: seeded motion with human statistics, for recordings free of any licence.

A head turns in gaze shifts along minimum-jerk profiles (Flash and Hogan 1985, The coordination of
arm movements, eq. 6), whose duration grows linearly with their amplitude: the main sequence of
heads (Zangemeister, Jones and Stark 1981, Dynamics of head movement trajectories). Between shifts
it drifts in slow submovements. It turns about the neck, sways, and bobs at each step. Glides are no
person's: they move in one way only, at a known speed, to tell apart what each kind of motion costs.
All randomness is `random.Random(seed).random()`, whose sequence Python guarantees everywhere.
"""

from __future__ import annotations

import math
import random
import tomllib
from bisect import bisect_right
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import IO, Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..base import InputError, unknown_name
from ..geometry import Pose
from . import quaternions
from .formats import write_native
from .track import Origin, PoseSample, PoseTrack

EYE_HEIGHT_M = 1.6
_START = (0.0, EYE_HEIGHT_M, 0.0)
WALK_M_S, FASTER = 1.4, 3.0  # a pedestrian's pace (Browning et al. 2006 measured 1.4 m/s); with shift, a run
STEEPEST_RAD = math.radians(89.0)
# Time constants of turning and walking. 20 ms: the steps of a mouse that is read at 60 Hz become a
# smooth turn; more would be noticeable. 80 ms: a step's start and stop.
TURN_S, WALK_S = 0.020, 0.080
HORIZON_NS = 50_000_000
KEPT_NS = 250_000_000
# No input for this long means that the program was suspended, or busy with a new scene.
DEAF_NS = 1_000_000_000


@attrs.frozen(eq=False)
class _State:
    """The head at an input's instant, and where it leads until the next."""

    time_ns: int
    position: tuple[float, ...] = _START
    velocity: tuple[float, ...] = (0.0, 0.0, 0.0)
    turned: tuple[float, ...] = (0.0, 0.0)  # yaw, pitch
    goal: tuple[float, float] = (0.0, 0.0)  # of these
    wish: tuple[float, float, float] = (0.0, 0.0, 0.0)  # m/s to the right, up and forward of the goal

    def after(self, time_ns: int) -> _State:
        """Return the state without further input: first-order lags, exact."""
        seconds = (time_ns - self.time_ns) * 1e-9
        late, slow = math.exp(-seconds / TURN_S), math.exp(-seconds / WALK_S)
        sine, cosine, (right, up, forward) = math.sin(self.goal[0]), math.cos(self.goal[0]), self.wish
        wish = right * cosine - forward * sine, up, -right * sine - forward * cosine
        axes = list(zip(self.position, self.velocity, wish, strict=True))
        return attrs.evolve(
            self, time_ns=time_ns, velocity=tuple(u + (v - u) * slow for _, v, u in axes),
            position=tuple(x + u * seconds + (v - u) * WALK_S * (1 - slow) for x, v, u in axes),
            turned=tuple(goal + (angle - goal) * late for angle, goal in zip(self.turned, self.goal, strict=True)),
        )  # fmt: skip


class Walker:
    """A head at eye height that turns and walks smoothly on command.

    Every input has its time; `advance` says that no more came until then. The path is a function of
    these alone, bit for bit, however often it is sampled. It walks along where it is turning to.
    Angles: yaw to the left, pitch up, radians; pitch within 89 degrees. An earlier time than the
    latest known counts as that.
    """

    def __init__(self, time_ns: int) -> None:
        self._now_ns, self._recentred = time_ns, 0
        self._states = deque([_State(time_ns)])

    def turn(self, time_ns: int, yaw_rad: float, pitch_rad: float) -> None:
        """Turn this much further to the left and up."""
        self.advance(time_ns)
        yaw, pitch = self._states[-1].goal
        self._input(goal=(yaw + yaw_rad, min(max(pitch + pitch_rad, -STEEPEST_RAD), STEEPEST_RAD)))

    def walk(
        self, time_ns: int, right: float = 0.0, up: float = 0.0, forward: float = 0.0, *, fast: bool = False
    ) -> None:
        """Walk on in this direction, -1..1 each, level with the ground; zeros stop."""
        length = max(1.0, math.hypot(right, forward))
        pace = WALK_M_S * (FASTER if fast else 1.0)
        wish = (pace * right / length, pace * up, pace * forward / length)
        self.advance(time_ns)
        if wish != self._states[-1].wish:
            self._input(wish=wish)

    def recentre(self, time_ns: int) -> None:
        """Jump back to the start, looking ahead; walking continues."""
        self._now_ns = max(time_ns, self._now_ns)
        self._recentred += 1
        self._states = deque([_State(self._now_ns, wish=self._states[-1].wish)])

    def advance(self, now_ns: int) -> None:
        """Note that there was no input until now."""
        if now_ns - self._now_ns > DEAF_NS:
            self._input(wish=(0.0, 0.0, 0.0))
        self._now_ns = max(now_ns, self._now_ns)

    def head_at(self, time_ns: int) -> PoseSample:
        """Return world_from_head, exact for the last quarter of a second at least, then HELD.

        The future is PREDICTED as if no input came, for 50 ms at most: the lags go on, so the head
        never overshoots when the hand stops.
        """
        known_ns = min(time_ns, self._now_ns + HORIZON_NS)
        i = bisect_right(self._states, known_ns, key=lambda state: state.time_ns) - 1
        state, origin = self._states[0], Origin.HELD
        if i >= 0:
            state, origin = self._states[i].after(known_ns), Origin.INTERPOLATED
        if time_ns >= self._now_ns:
            origin = Origin.MEASURED if time_ns == self._now_ns else Origin.PREDICTED
        (sy, cy), (sp, cp) = ((math.sin(angle / 2), math.cos(angle / 2)) for angle in state.turned)
        pose = Pose(state.position, (cy * sp, sy * cp, -sy * sp, cy * cp))  # y after the head's x: never any roll
        return PoseSample(time_ns, pose, origin, read_ns=self._now_ns, space=self._recentred)

    def _input(self, **changes: Any) -> None:
        """Change the state at the latest known instant."""
        self._states.append(attrs.evolve(self._states[-1].after(self._now_ns), **changes))
        while self._states[1].time_ns <= self._now_ns - KEPT_NS:
            self._states.popleft()


Array = NDArray[np.float64]

# From the top of the neck to between the eyes: up and forward, as in the neck models of mobile VR
# (0.075 m and 0.080 m).
_NECK_TO_EYES_M = np.array([0.0, 0.075, -0.080])
# A shift of A degrees takes 0.28 s + 5.8 ms/degree: 10 degrees peak at 55 deg/s, 30 at 124, 90 at
# 210. Chosen, with the pauses and the drift of `_look_around`, to meet the speeds of 264 recorded
# heads (30/113/191 deg/s at p50/p95/p99).
_SHIFT_BASE_S, SHIFT_PER_DEG_S = 0.28, 0.0058
DECIMALS = (6, 8)  # 1 um and 1e-8: coarser than the last bit, in which sines may differ between machines
RATE_HZ = 90.0
_LONGEST_S, _FASTEST_HZ = 3600.0, 1000.0


# A minimum-jerk change of one angle: its start and length in seconds, by how many degrees.
Shift = tuple[float, float, float]


@attrs.frozen(eq=False)
class Motion:
    """Angles in degrees and the neck's place in metres, over time."""

    yaw: Array  # to the left
    pitch: Array  # up
    roll: Array  # the right shoulder's left
    place: Array
    neck_to_eyes_m: Array = _NECK_TO_EYES_M  # zeros for a head that turns about its eyes


# Of a glide: `room`, the largest shipped scene, can be walked in to 1.6 m from
# where a head begins.
_LEAST = 1e-3
EASE_S = 0.2  # 0.5 m/s is reached at 4.7 m/s2 at most, as a person sets off


@attrs.frozen
class Glide:
    """A motion there and back, without a pause: along a line, or about the upright axis.

    Each way begins and ends at rest: the speed grows along a minimum-jerk profile for `EASE_S`,
    stays, and falls the same way, so the head never goes farther than the amplitude or faster.
    Errors of `with_`: InputError for a speed or amplitude out of range.
    """

    speed: float  # at most, in m or degrees per second
    amplitude: float  # distance of the turning point from the start, in m or degrees
    direction: Sequence[float] | None = None  # of the way out, as a unit vector; None turns to the left

    def with_(self, speed: float | None, amplitude: float | None) -> Glide:
        """Return it with another speed or amplitude; None keeps its own."""
        speed, amplitude = self.speed if speed is None else speed, self.amplitude if amplitude is None else amplitude
        unit, fastest, farthest = ("degrees", 720.0, 360.0) if self.direction is None else ("m", 5.0, 1.5)
        if not _LEAST <= speed <= fastest:
            raise InputError(f"speed {speed:g} {unit} per second: expected {_LEAST:g} to {fastest:g}")
        if not _LEAST <= amplitude <= farthest:
            raise InputError(f"amplitude {amplitude:g} {unit}: expected {_LEAST:g} to {farthest:g}")
        return attrs.evolve(self, speed=speed, amplitude=amplitude)

    @property
    def ease_s(self) -> float:
        """Return how long it takes to reach the speed: EASE_S, less for a short way."""
        return min(EASE_S, self.amplitude / self.speed)

    @property
    def steady_s(self) -> tuple[float, float]:
        """Return the seconds between which the first way out has its full speed."""
        return self.ease_s, self.amplitude / self.speed

    def way(self, t: Array) -> Array:
        """Return the distance from the start at the seconds t: 0 to the amplitude and back."""

        def eased(t: Array) -> Array:  # the integral of a minimum-jerk step from 0 to 1 that begins at 0
            s = np.clip(t / self.ease_s, 0.0, 1.0)
            return self.ease_s * (s**4 * (2.5 + s * (s - 3.0))) + np.maximum(t - self.ease_s, 0.0)

        leg_s = self.amplitude / self.speed + self.ease_s
        phase = np.mod(t, 2 * leg_s)
        out_s = np.minimum(phase, 2 * leg_s - phase)
        return self.speed * (eased(out_s) - eased(out_s - self.amplitude / self.speed))


@attrs.frozen
class Kind:
    """A kind of synthetic motion."""

    name: str
    summary: str
    seconds: float  # length of the shipped recording
    # (rng, seconds, t) -> the motion at the instants t; or a motion of known speed and amplitude.
    build: Callable[[random.Random, float, Array], Motion] | Glide
    seed: int | None = None  # of the shipped recording; None for a motion that has nothing random


def synthesise(
    kind: str, seed: int | None = None, seconds: float | None = None, rate_hz: float = RATE_HZ, *,
    speed: float | None = None, amplitude: float | None = None,
) -> PoseTrack:  # fmt: skip
    """Return a synthetic head track: standing at (0, 1.6, 0), looking to -z.

    kind: one of `KINDS`. seed and seconds: by default those of the shipped recording. rate_hz:
    samples per second. speed, amplitude: of a `Glide`, in m/s and m, or in degrees per second and
    degrees. Errors: UnknownNameError; InputError for a number out of range or not of the motion.
    """
    if kind not in KINDS:
        raise unknown_name("kind of motion", kind, sorted(KINDS))
    build = KINDS[kind].build
    seconds = KINDS[kind].seconds if seconds is None else seconds
    if not 0.1 <= seconds <= _LONGEST_S:
        raise InputError(f"--seconds {seconds:g}: expected a length from 0.1 to {_LONGEST_S:g}")
    if not 1 <= rate_hz <= _FASTEST_HZ:
        raise InputError(f"--rate {rate_hz:g} Hz: expected 1 to {_FASTEST_HZ:g}")
    t = np.arange(math.floor(seconds * rate_hz + 1e-9) + 1) / rate_hz
    if isinstance(build, Glide):
        if seed is not None:
            raise InputError(f"--seed {seed}: motion {kind} has nothing random; leave the seed out")
        glide, still = build.with_(speed, amplitude), np.zeros_like(t)
        flags, way = f"--speed {glide.speed:g} --amplitude {glide.amplitude:g}", glide.way(t)
        place = np.outer(way, glide.direction or (0.0, 0.0, 0.0)) + np.array(_START)
        motion = Motion(way if glide.direction is None else still, still, still, place, neck_to_eyes_m=np.zeros(3))
    else:
        if speed is not None or amplitude is not None:
            what = f"--speed and --amplitude: motion {kind} has the speeds of people"
            raise InputError(f"{what}; expected one of {', '.join(sorted(GLIDES))}")
        seed = KINDS[kind].seed if seed is None else seed
        if seed is None or seed < 0:
            raise InputError(f"--seed {seed}: expected 0 or more")  # Python seeds -1 and 1 alike
        motion, flags = build(random.Random(seed), seconds, t), f"--seed {seed}"
    # Each about the axis turned by those before.
    angles = zip((motion.yaw, motion.pitch, motion.roll), np.eye(3)[[1, 0, 2]], strict=True)
    turns = [quaternions.from_rotation_vector(np.outer(np.radians(angle), axis)) for angle, axis in angles]
    orientation = quaternions.multiply(quaternions.multiply(turns[0], turns[1]), turns[2])
    quaternions.make_continuous(orientation)
    position = motion.place + quaternions.rotate(orientation, motion.neck_to_eyes_m[None])
    how = f"hmdwarp trace synth {kind} {flags} --seconds {seconds:g} --rate {rate_hz:g}"
    made = f"synthetic, generated by '{how}'; {KINDS[kind].summary}"
    return PoseTrack(np.rint(t * 1e9).astype(np.int64), position, orientation, name=kind, origin=made)


def write_synthetic(track: PoseTrack, stream: IO[str]) -> None:
    """Write native CSV, rounded to `DECIMALS`: the same seed gives the same bytes everywhere."""
    write_native(track, stream, DECIMALS)


def shift_seconds(amplitude_deg: float, vigour: float = 1.0) -> float:
    """Return the duration of a gaze shift; vigour above 1 is faster."""
    return (_SHIFT_BASE_S + SHIFT_PER_DEG_S * abs(amplitude_deg)) / vigour


def minimum_jerk(share: Array) -> Array:
    """Return 0 to 1 along 10 s^3 - 15 s^4 + 6 s^5, at rest at both ends; share is clipped."""
    s = np.clip(share, 0.0, 1.0)
    return s * s * s * (10.0 + s * (6.0 * s - 15.0))


def _sum_of(shifts: list[Shift], t: Array) -> Array:
    return sum((amount * minimum_jerk((t - start) / length) for start, length, amount in shifts), np.zeros_like(t))


def _between(rng: random.Random, low: float, high: float) -> float:
    return low + (high - low) * rng.random()


def _sines(rng: random.Random, t: Array, amplitude: float, low_hz: float, high_hz: float) -> Array:
    """Return sines over a band, as 1/f, of sum `amplitude` at most, which is 0 at t = 0."""
    out, weights, count = np.zeros_like(t), 0.0, 4
    for i in range(count):
        hz = low_hz * (high_hz / low_hz) ** ((i + _between(rng, 0.2, 0.8)) / count)
        phase = _between(rng, 0, 2 * math.pi)
        out += (np.sin(2 * math.pi * hz * t + phase) - math.sin(phase)) / hz
        weights += 2 / hz
    return out * (amplitude / weights)


def _sway(rng: random.Random, t: Array, size: float = 1.0) -> Array:
    """Return a standing person's neck. Source: Winter 1995, Human balance and posture control."""
    sizes = (0.012, 0.1, 0.9), (0.003, 0.2, 0.6), (0.022, 0.1, 0.9)
    sway = np.stack([_sines(rng, t, *each) for each in sizes], axis=1)
    return np.asarray(size * sway + np.array(_START) - _NECK_TO_EYES_M)


def _wander(rng: random.Random, seconds: float, span: float, speed: tuple[float, float]) -> list[Shift]:
    """Return slow submovements between -span and span degrees, at mean speeds in deg/s."""
    shifts, now, angle = [], 0.0, 0.0
    while now < seconds:
        target = _between(rng, -span, span)
        length = max(abs(target - angle) / _between(rng, *speed), 0.4)
        # Each begins before the last has ended: a drifting head never quite stops.
        shifts.append((now, length, target - angle))
        now, angle = now + 0.75 * length, target
    return shifts


def _gaze_targets(rng: random.Random, span: float, least: float, mean: float = math.inf) -> Iterator[float]:
    """Return yaw targets within +-span degrees, `least` to about `mean` further than the last."""
    angle = 0.0
    while True:
        if math.isinf(mean):
            target = _between(rng, -span, span)
        else:
            reach = least - mean * math.log(1 - rng.random())
            outwards = rng.random() < 0.5 - 0.4 * abs(angle) / span  # heads come back to the front
            target = angle + math.copysign(reach, angle if outwards else -angle)
        if abs(target) <= span and abs(target - angle) >= least:
            yield target
            angle = target


def _still(rng: random.Random, seconds: float, t: Array) -> Motion:
    yaw, pitch, roll = (_sines(rng, t, *size) for size in ((4.0, 0.1, 1.2), (3.0, 0.1, 1.2), (1.5, 0.1, 1.0)))
    return Motion(yaw, pitch, roll, _sway(rng, t))


def _look_around(rng: random.Random, seconds: float, t: Array) -> Motion:
    yaw, pitch, now, angle, tilt = [], [], 0.6, 0.0, 0.0
    targets = _gaze_targets(rng, 80, 8, 26)
    while now < seconds:
        target, height = next(targets), _between(rng, -18, 14)
        across, up = target - angle, height - tilt
        hurried = rng.random() < 0.1
        length = shift_seconds(math.hypot(across, up), _between(rng, 1.3, 1.6) if hurried else _between(rng, 0.7, 1.1))
        yaw.append((now, length, across))
        pitch.append((now + 0.03, length, up))
        angle, tilt = target, height
        now += length + _between(rng, 0.4, 1.8)
    drift = _sum_of(_wander(rng, seconds, 17, (14, 34)), t)
    nod = _sum_of(_wander(rng, seconds, 8, (5, 14)), t)
    turned = _sum_of(yaw, t) + drift
    # The head leans a little into a turn.
    return Motion(turned, _sum_of(pitch, t) + nod, 0.04 * turned + _sines(rng, t, 2.0, 0.1, 0.8), _sway(rng, t, 4.0))


def _reversals(rng: random.Random, seconds: float, t: Array) -> Motion:
    yaw, now, angle = [], 0.8, 0.0
    while now < seconds:
        reach, vigour = _between(rng, 15, 40), _between(rng, 0.9, 1.25)
        side = 1 if rng.random() < 0.5 else -1
        for _ in range(3 + int(4 * rng.random())):
            amount = side * reach - angle
            length = shift_seconds(amount, vigour)
            yaw.append((now, length, amount))
            now, angle, side = now + length, side * reach, -side
        now += _between(rng, 0.3, 0.9)
    return Motion(_sum_of(yaw, t), _sines(rng, t, 3.0, 0.2, 1.2), _sines(rng, t, 1.5, 0.2, 1.0), _sway(rng, t))


def _fast_turns(rng: random.Random, seconds: float, t: Array) -> Motion:
    yaw, now, angle = [], 0.8, 0.0
    targets = _gaze_targets(rng, 120, 60)
    while now < seconds:
        target = next(targets)
        length = shift_seconds(target - angle, _between(rng, 1.1, 1.5))
        yaw.append((now, length, target - angle))
        angle = target
        now += length + _between(rng, 0.5, 1.1)
    return Motion(_sum_of(yaw, t), _sines(rng, t, 4.0, 0.2, 1.0), _sines(rng, t, 2.0, 0.2, 1.0), _sway(rng, t))


_WALK_HALF_AXES_M = (0.68, 1.2)
_STEP_HZ = 1.8
_LAP_S = 8.5
_LEAD_S = 0.35


def _walk(rng: random.Random, seconds: float, t: Array) -> Motion:
    """Return laps of two ellipses that touch at the start, one to the left, one to the right."""

    def pace(t: Array) -> Array:  # 0 standing, 1 walking: starts within 1.5 s from 0.5 s, stops so too
        return minimum_jerk((t - 0.5) / 1.5) * minimum_jerk((seconds - 0.3 - t) / 1.5)

    # On a fine fixed grid, so that the path does not depend on the sampling rate.
    grid = np.arange(0.0, seconds + 2.0, 1 / 1000)
    laps = np.concatenate([[0.0], np.cumsum(pace(grid))[:-1]]) / 1000 / _LAP_S

    def path(t: Array) -> tuple[Array, Array]:  # (n, 3) place of the neck, and heading in degrees
        lap = np.interp(t, grid, laps)
        whole = np.floor(lap)
        phase = 2 * math.pi * (lap - whole)
        side = np.where(whole % 2 == 0, -1.0, 1.0)  # first to the left
        a, b = _WALK_HALF_AXES_M
        x, z = side * a * (1 - np.cos(phase)), -b * np.sin(phase)
        turned = np.degrees(np.unwrap(np.arctan2(-side * a * np.sin(phase), b * np.cos(phase)), period=2 * math.pi))
        return np.stack([x, np.full_like(t, EYE_HEIGHT_M), z], axis=1) - _NECK_TO_EYES_M, turned

    # Constant pace in the ellipse's parameter is the two-thirds power law of human curved motion
    # (Lacquaniti et al. 1983); the head turns ahead of the path (Grasso et al. 1996, 0.2 to 0.5 s).
    place, going = path(t)[0], pace(t)
    step = 2 * math.pi * _STEP_HZ * t
    bob = 0.022 * going * np.sin(step + 0.5 * math.pi)
    heading = path(t + _LEAD_S * going)[1]
    side = 0.018 * going * np.sin(step / 2)
    turned = np.radians(heading)
    place = place + side[:, None] * np.stack([np.cos(turned), np.zeros_like(t), -np.sin(turned)], axis=1)
    place[:, 1] += bob
    shifts, now = [], _between(rng, 2.0, 3.0)  # glances to the sides and back
    while now < seconds - 2:
        amount = _between(rng, 15, 45) * (1 if rng.random() < 0.5 else -1)
        length = shift_seconds(amount, 0.9)
        stay = _between(rng, 0.3, 0.9)
        shifts += [(now, length, amount), (now + length + stay, length, -amount)]
        now += 2 * length + stay + _between(rng, 1.0, 2.5)
    glances = _sum_of(shifts, t)
    # The head nods against the bob and so keeps the gaze steady (Pozzo et al. 1990).
    pitch = -6.0 * going - 1.0 * going * np.sin(step + 0.5 * math.pi) + _sines(rng, t, 3.0, 0.1, 0.7)
    roll = 0.8 * going * np.sin(step / 2) + _sines(rng, t, 1.0, 0.1, 0.7)
    place = place + 0.5 * (_sway(rng, t) - np.array([0.0, EYE_HEIGHT_M, 0.0]) + _NECK_TO_EYES_M)
    return Motion(heading + glances, pitch, roll, place)


_PEOPLE = (_still, _look_around, _reversals, _walk, _fast_turns)  # kinds of their names
_BUILDS = {build.__name__[1:].replace("_", "-"): build for build in _PEOPLE}
_TABLE = tomllib.loads(Path(__file__).with_suffix(".toml").read_text("utf-8"))
KINDS: dict[str, Kind] = {
    name: Kind(name, build=Glide(**told.pop("glide")) if "glide" in told else _BUILDS[name], **told)
    for name, told in _TABLE.items()
}
GLIDES: dict[str, Glide] = {name: kind.build for name, kind in KINDS.items() if isinstance(kind.build, Glide)}
