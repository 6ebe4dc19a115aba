"""From a file's axes to OpenXR's (+x right, +y up, -z forward), weighed against its motion.

Is that a person's, upright, forward, at human sizes? What contradicts the reading is named, with
the reading that fits.
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Sequence
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...base import InputError, Registry, TraceError
from .. import quaternions
from ..assumptions import AXES_BY, DIRECTION, Assumption, By, Fact, Layout
from ..options import COLUMNS, DIRECT, INVERSE, ROWS, TraceOptions
from ..track import PoseSample
from .columns import columns_read
from .text_table import Recording

Array = NDArray[np.float64]

OPENXR = "openxr"
_AXES = {"x": (1.0, 0, 0), "y": (0, 1.0, 0), "z": (0, 0, 1.0)}
_SYNTAX = "a preset of 'hmdwarp list axes', or world=right,up,forward head=right,up,forward (world=x,z,y head=x,-y,z)"
_PARTS = re.compile(r"\b(world|head)\s*=\s*([^\s;]+)")


@attrs.frozen(eq=False)
class Axes:
    """Axes of a file, relative to OpenXR's, of the world and of the head.

    Both have the same hand: orientation_openxr = world @ orientation_file @ head.T, as matrices.
    """

    world: Array  # (3, 3), rows are OpenXR's right, up and back in the file's world axes
    head: Array  # (3, 3), the same in the axes of the file's head
    # xyzw, a turn of the world alone that follows (gravity set upright; the head's own axes stay)
    tilt: Array | None = None
    metres_per_unit: float | None = None  # of files with these axes, if they state it
    name: str = ""  # of axes that many files share, a preset
    summary: str = ""
    source: str = ""

    def __attrs_post_init__(self) -> None:
        if np.linalg.det(self.world) * np.linalg.det(self.head) < 0:
            what = "one of the two is left-handed and the other right-handed"
            raise InputError(f"--axes {self.words()}: {what}; a rotation keeps the hand, so turn one axis around")

    def words(self) -> str:
        bases = ((basis[0], basis[1], -basis[2]) for basis in (self.world, self.head))
        world, head = (",".join(map(_axis_word, rows)) for rows in bases)
        return f"world={world} head={head}"

    def label(self) -> str:
        return f"{self.name} ({self.words()})" if self.name else self.words()

    def up(self) -> str:
        """Return the world's up as an axis of the file, for instance "z"."""
        return _axis_word(self.world[1])

    @property
    def reading(self) -> Array:
        """Up of the world, up and forward of the head, (3, 3), as in _READINGS."""
        return np.array([self.world[1], self.head[1], -self.head[2]])

    def apply(self, position: Array | None, orientation: Array) -> None:
        """Convert positions (n, 3) and quaternions (n, 4), in place.

        Under a change of basis B a rotation about v becomes one about B v by det(B) times the
        angle; where the head's basis is another one, a fixed turn of the head follows.
        """
        if not np.array_equal(self.world, np.eye(3)):
            orientation[:, :3] = orientation[:, :3] @ (round(np.linalg.det(self.world)) * self.world).T
            if position is not None:
                position[:] = position @ self.world.T
        if not np.array_equal(self.world, self.head):
            from scipy.spatial.transform import Rotation

            turn = Rotation.from_matrix(self.world @ self.head.T).as_quat()
            orientation[:] = quaternions.multiply(orientation, turn)
        if self.tilt is not None:
            orientation[:] = quaternions.multiply(self.tilt, orientation)
            if position is not None:
                position[:] = quaternions.rotate(self.tilt, position)


presets: Registry[Axes] = Registry(
    "axes preset", __package__.replace(".reading", ".presets"),
    of_table=lambda name, told: Axes(_basis(told.pop("world")), _basis(told.pop("head")), name=name, **told),
)  # fmt: skip


def parse_axes(text: str) -> Axes:
    """Parse `--axes`: a preset, or "world=right,up,forward head=right,up,forward".

    One of the two, or three axes alone, hold for both. Errors: InputError, UnknownNameError.
    """
    text = text.strip().lower()
    found: dict[str, str] = dict(_PARTS.findall(text))
    if found:
        if _PARTS.sub("", text).strip(" ,;"):
            raise InputError(f"--axes '{text}': expected {_SYNTAX}")
        world = _basis(found.get("world", found.get("head", "")))
        return Axes(world, _basis(found.get("head", found.get("world", ""))))
    if "," in text:
        return Axes(_basis(text), _basis(text))
    if not re.fullmatch(r"[a-z][a-z0-9 _-]*", text):
        raise InputError(f"--axes '{text}': expected {_SYNTAX}")
    return presets.get(re.sub(r"[ _]", "-", text))


def parse_up(text: str) -> Array:
    """Parse `--up`, what is really up in a file of tilted gravity: the smallest turn there, xyzw.

    Errors: InputError.
    """
    try:
        up = np.array([float(field) for field in text.split(",")])
    except ValueError:
        up = np.zeros(0)
    length = float(np.linalg.norm(up))
    if up.shape != (3,) or not (math.isfinite(length) and length > 1e-6):
        wanted = "three numbers, not all zero (0.04,0.95,0.3); --axes names axes (x,z,y where z is up)"
        raise InputError(f"--up '{text}': expected {wanted}")
    up = up / length
    # The half-way quaternion from up to +y; straight down has no smallest turn, x is taken.
    half = np.array([-up[2], 0.0, up[0], 1.0 + up[1]]) if up[1] > -1 + 1e-12 else np.array([1.0, 0, 0, 0])
    return np.asarray(half / np.linalg.norm(half))


def _basis(words: str) -> Array:
    rows = []
    for word in words.split(","):
        sign, letter = (-1.0, word[1:]) if word.startswith("-") else (1.0, word.removeprefix("+"))
        if letter not in _AXES:
            raise InputError(f"axis '{word}': expected x, y or z, with or without a sign")
        rows.append(np.array(_AXES[letter]) * sign)
    basis = np.array(rows)
    if basis.shape != (3, 3) or abs(abs(np.linalg.det(basis)) - 1) > 1e-9:
        raise InputError(f"--axes '{words}': expected three different ones, right,up,forward, for instance x,z,y")
    basis[2] *= -1  # OpenXR's z points back
    return basis


def _axis_word(direction: Array) -> str:
    """Return the axis that a direction (3,) points along most, such as "-z"."""
    k = int(np.abs(direction).argmax())
    return ("-" if direction[k] < 0 else "") + "xyz"[k]


# People keep their heads within about 30 degrees of upright, so the crown's mean is within 45.
UPRIGHT = 0.7
_ON_ITS_SIDE = 0.5  # cosine: the crown is over 60 degrees from up in the mean
# A head that turns about one axis with this share of its rotation turns about up (people turn more
# than they nod, and nod more than they roll), and is not read right if up has less than the other.
_TURNS_MOSTLY = 0.6
_TURNS_HARDLY = 0.2
_LEAST_TURNED_RAD = 2.0  # below that a few nods decide
# Walking: faster than a sway, over a second in total. People rarely walk backwards or sideways.
_WALKING_M_S = 0.3
_WALKED_S = 1.5
_FASTEST_M_S = 5.0
_COHERENT = 0.4  # length of the mean direction of travel in the head's axes
# The eyes lie about 8 cm before and above the neck they turn about: accelerations of the tracked
# point tell where it lies in the head. Measured: the share of them that this explains is 0.2 in
# real recordings of seated people, and 1 in synthetic ones.
_EXPLAINED = 0.15
_NECK_M = (0.015, 0.3)
_TIPPED = 0.005  # mean square: 4 degrees
_WELL_UPRIGHT = 0.85
_STEP_NS = 100_000_000
_MOST_STEPS = 20_000
_LEAST_STEPS = 8
_HEIGHTS_M = (0.4, 2.4)  # of eyes over a floor, sitting children to standing adults
CLEAR = 0.4  # of points: what one criterion alone is worth at half strength
SURE = 0.8  # where nothing else contradicts a reading
# The fastest recorded head turns reach about 800 deg/s and 6 m/s; a jump is far beyond that and too
# large to be noise.
_JUMP_SPEED_RAD_S = np.radians(2000)
_JUMP_ANGLE_RAD = np.radians(20)
_JUMP_SPEED_M_S = 15.0
_JUMP_DISTANCE_M = 0.25
# Readings, what axes mean for a head: up of the world, up and forward of the head, as signed unit
# vectors of the file, (3, 3). Right follows, and directions on the ground are free.
_SIGNED = np.concatenate([np.eye(3), -np.eye(3)])
_READINGS = np.array([three for three in itertools.product(_SIGNED, repeat=3) if not three[1] @ three[2]])


class Evidence:
    """What the poses of a file, in its own axes, say about which way is up and forward."""

    def __init__(self, time_ns: NDArray[np.int64], q: Array, p: Array | None, gravity: Array) -> None:
        """Collect it of unit quaternions q (n, 4) and positions p (n, 3), about 0.1 s apart.

        None is compared over a gap or teleport. gravity: down, (3,); zeros: unknown.
        """
        t, axes = time_ns * 1e-9, np.stack([quaternions.rotate(q, unit) for unit in np.eye(3)], axis=2)  # matrices
        near = np.diff(t) < 5e-9 * _STEP_NS
        self.upright = axes.mean(axis=0)  # (3, 3), mean cosine between axis i of the world and axis j of the head
        self.tips = (axes**2).mean(axis=0)  # (3, 3), mean square of that cosine
        self.gravity = -gravity / (np.linalg.norm(gravity) or 1.0)  # (3,), up; zeros: unknown
        self.world_turns = self.head_turns = np.zeros(3)  # share of the rotation about each axis; zeros: too little
        self.travel = np.zeros(3)  # mean direction of travel in the head's axes; zeros: no walk
        self.climb = np.zeros(3)  # share of the way along each axis of the world; zeros: no walk
        self.neck = np.zeros(3)  # unit vector from the neck to the tracked point, in the head's axes; zeros: unknown
        self.height_m = np.zeros(3)  # mean position where it is steady along an axis, else 0
        self.path_m = 0.0  # the way that the head goes; 0 without positions
        vectors = quaternions.vector_between(q[:-1], q[1:])[near]
        length = np.linalg.norm(vectors, axis=1)
        vectors = vectors[length < 1.0]  # over 10 rad/s: a teleport
        if len(vectors) >= _LEAST_STEPS and length[length < 1.0].sum() > _LEAST_TURNED_RAD:
            in_head = np.einsum("nij,ni->nj", axes[:-1][near][length < 1.0], vectors)
            self.world_turns, self.head_turns = _shares(vectors), _shares(in_head)
        if p is None:
            return
        velocity = np.diff(p, axis=0)[near] / np.diff(t)[near][:, None]
        speed = np.linalg.norm(velocity, axis=1)
        self.path_m = float((speed * np.diff(t)[near]).sum())
        walks = (speed > _WALKING_M_S) & (speed < _FASTEST_M_S)
        if np.count_nonzero(walks) * 1e-9 * _STEP_NS > _WALKED_S:
            unit = velocity[walks] / speed[walks][:, None]
            self.travel = np.einsum("nij,ni->nj", axes[:-1][near][walks], unit).mean(axis=0)
            self.climb = _shares(velocity[walks])
        # Accelerations of the tracked point by a fixed lever in the head: p'' = R'' lever.
        moved, turned = (part[:-2] - 2 * part[1:-1] + part[2:] for part in (p, axes))
        calm = near[1:] & near[:-1] & (np.linalg.norm(moved, axis=1) < 0.5)
        a, b = turned[calm].reshape(-1, 3), moved[calm].reshape(-1)
        if calm.sum() >= _LEAST_STEPS and b.any():
            lever = np.linalg.lstsq(a, b, rcond=None)[0]
            explained, length_m = 1 - float(((a @ lever - b) ** 2).sum() / (b**2).sum()), float(np.linalg.norm(lever))
            if explained > _EXPLAINED and _NECK_M[0] < length_m < _NECK_M[1]:
                self.neck = lever / length_m
        self.height_m = np.where(p.std(axis=0) < 0.25, p.mean(axis=0), 0.0)

    def weigh(self, readings: Array) -> tuple[Array, NDArray[np.bool_], str]:
        """Return points, one a criterion, gravity two; which are wrong; the first's fault."""
        up, crown, gaze = readings.transpose(1, 0, 2)
        level, cosine = up @ self.gravity, (up @ self.upright * crown).sum(axis=1)
        turns, nods = np.abs(up) @ self.world_turns, np.abs(crown) @ self.head_turns
        climbs, walks, faces = np.abs(up) @ self.climb, gaze @ self.travel, gaze @ self.neck
        points = 2.0 * level + cosine + (turns + nods) + (walks - climbs + faces)
        tips = np.abs(up) @ self.tips  # mean squares of how far gaze and ears leave the horizon
        pitched, rolled = (tips * np.abs(gaze)).sum(axis=1), (tips * (1 - np.abs(crown) - np.abs(gaze))).sum(axis=1)
        both = pitched + rolled
        points += np.where(both > _TIPPED, 0.5 * (pitched - rolled) / np.maximum(both, _TIPPED), 0.0)
        height, walked = up @ self.height_m, float(np.linalg.norm(self.travel))
        stands, buried = (height >= _HEIGHTS_M[0]) & (height <= _HEIGHTS_M[1]), height <= -_HEIGHTS_M[0]
        points += 0.5 * stands - 0.5 * (height < -_HEIGHTS_M[0])
        hardly = (self.world_turns.max() > _TURNS_MOSTLY) & (turns < _TURNS_HARDLY)
        hardly |= (self.head_turns.max() > _TURNS_MOSTLY) & (nods < _TURNS_HARDLY)
        way = "backwards" if walks[0] < -UPRIGHT * walked else "sideways"
        side = "behind" if faces[0] < -UPRIGHT else "beside"
        tests = {
            "the file's gravity columns point another way": self.gravity.any() & (level < UPRIGHT),
            "the head is upside down": cosine < -UPRIGHT,
            "the head lies on its side": (cosine < _ON_ITS_SIDE) & (np.abs(self.upright).max() >= UPRIGHT),
            "the head hardly turns about its upright axis, but about another": hardly,
            "the head climbs instead of walking": (self.climb.max() > _TURNS_MOSTLY) & (climbs > _TURNS_MOSTLY),
            f"the head walks {way}": (walked > _COHERENT) & (walks < 0.3 * walked),
            f"the face is {side} the neck that it turns about": self.neck.any() & (faces < 0.3),
            "the head rolls from side to side more than it nods": (
                (cosine > _WELL_UPRIGHT) & (rolled > np.maximum(3 * pitched, _TIPPED))
            ),
            f"the head is {-height[0]:.2f} m below the floor": buried & (height >= -_HEIGHTS_M[1]),
        }
        return points, np.any([*tests.values()], axis=0), next((why for why, holds in tests.items() if holds[0]), "")

    def best_points(self) -> float:
        return float(self.weigh(_READINGS)[0].max())


class Verdict:
    """How axes compare with all others: 6 ups of the world, 24 directions of the head.

    Motion shows neither the hand of a file nor directions on the ground: a mirrored walk is a walk.
    """

    def __init__(self, evidence: Evidence, axes: Axes) -> None:
        self.better: Axes | None = None  # what fits best; None: nothing fits better
        here = axes.reading
        # fault: what contradicts them, "" for nothing
        points, contradicted, self.fault = evidence.weigh(np.concatenate([[here], _READINGS]))
        own, top, best = points[0], points[1:].max(), _READINGS[points[1:].argmax()]
        rivals = _READINGS[(points > own - CLEAR)[1:] & ~contradicted[1:]]
        self.confirmed = bool((rivals == here).all())  # the motion shows these axes alone
        self.advice = "nothing else fits better: --axes states them"
        self.world_alone = np.array_equal(best[1:], here[1:])  # the better ones turn it: the head's are right
        if not self.fault or np.array_equal(best, here) or top - own < CLEAR / 2:
            return
        fitting = [preset for preset in presets if np.array_equal(preset.reading, best)]
        up, crown, gaze = best
        ahead = np.roll(np.abs(up), 1)  # on the ground, the next axis after up; all right-handed
        sides = ((np.cross(ahead, up), up, ahead), (np.cross(gaze, crown), crown, gaze))
        world, head = (",".join(map(_axis_word, side)) for side in sides)
        self.better = better = fitting[0] if fitting else parse_axes(f"world={world} head={head}")
        also = ", ".join(axes.name for axes in fitting[1:])
        also = f" (so do {also}; motion cannot tell them apart)" if also else ""
        self.advice = f"--axes '{better.name or better.words()}' fits better{also}: {top:.1f} points against {own:.1f}"


# What heads do: how far from the origin of a tracked place, how fast.
_FARTHEST_M, _FASTEST_WALK_M_S = 50.0, 12.0
_LENGTHS = {"centimetres": 0.01, "millimetres": 0.001, "inches": 0.0254, "feet": 0.3048}


def _place_fault(time_ns: NDArray[np.int64], position_m: Array, height_m: float) -> tuple[str, str]:
    """Return what is odd about places, and a scale that helps, or "" twice. height_m: or 0."""
    far = float(np.median(np.linalg.norm(position_m, axis=1)))
    speed = np.linalg.norm(np.diff(position_m, axis=0), axis=1) / np.diff(time_ns * 1e-9)
    fast = float(np.quantile(speed, 0.9)) if len(speed) else 0.0
    odd = far > _FARTHEST_M or fast > _FASTEST_WALK_M_S
    what = f"the head is {far:.4g} m from the origin" if far > _FARTHEST_M else f"the head moves at {fast:.4g} m/s"
    for name, metres in _LENGTHS.items():
        if odd and far * metres < 5 and fast * metres <= 3:
            found = f"{name}: {far * metres:.3g} m, {fast * metres:.2g} m/s"
            return what, f"--scale {metres:g} takes the positions as {found}"
        if not odd and height_m > _HEIGHTS_M[1] and _HEIGHTS_M[0] <= height_m * metres <= _HEIGHTS_M[1]:
            remedy = f"if the floor is there, --scale {metres:g} takes it as {name}: {height_m * metres:.3g} m"
            return f"the head is {height_m:.3g} m above the origin", remedy
    return (what, "--scale gives metres per unit") if odd else ("", "")


def inverted(orientation: Array, position_m: Array | None) -> tuple[Array, Array | None]:
    """Return (n, 4) quaternions of any length and (n, 3) positions of the inverse poses."""
    turned = quaternions.conjugate(orientation)
    if position_m is None:
        return turned, None
    return turned, -quaternions.rotate(turned / np.linalg.norm(turned, axis=1, keepdims=True), position_m)


def _shares(vectors: Array) -> Array:
    squares = (vectors**2).sum(axis=0)
    return np.asarray(squares / (squares.sum() or 1.0))


def find_jumps(time_ns: NDArray[np.int64], orientation: Array, position: Array | None) -> NDArray[np.int64]:
    """Return indices i whose step to row i + 1 is too far and too fast, in angle or place."""
    seconds = np.diff(time_ns) * 1e-9
    angle = quaternions.angle_between(orientation[:-1], orientation[1:])
    jump = (angle > _JUMP_ANGLE_RAD) & (angle > _JUMP_SPEED_RAD_S * seconds)
    if position is not None:
        distance = np.linalg.norm(np.diff(position, axis=0), axis=1)
        jump |= (distance > _JUMP_DISTANCE_M) & (distance > _JUMP_SPEED_M_S * seconds)
    return np.flatnonzero(jump)


def jumps_between(samples: Sequence[PoseSample]) -> list[int]:
    """Return indices i whose step to sample i + 1 is one of `find_jumps`, or to another space."""
    times = np.array([sample.time_ns for sample in samples], np.int64)
    turned = np.array([sample.pose.orientation_xyzw for sample in samples])
    found = find_jumps(times, turned, np.array([sample.pose.position_m for sample in samples]))
    changed = np.flatnonzero(np.diff([sample.space for sample in samples]))
    return [int(i) for i in np.union1d(found, changed)]


def gravity_axis(orientation: Array) -> Array | None:
    """Return the direction in the world, (3,), that is up for the head; None if that is not clear.

    The axis through the ears stays level, as people turn and nod far more than they tilt: up is
    where it has the smallest component, which is small (5 %, an rms roll of 13 degrees), and the
    next five times as much, 5 % at least (the head has turned).
    """
    q = orientation[:: max(1, len(orientation) // 100_000)]  # of so many rows at most
    if len(q) < 100:
        return None
    right = quaternions.rotate(q, np.array([[1.0, 0, 0]]))
    share, axes = np.linalg.eigh(right.T @ right / len(q))
    if not share[0] < 0.05 < share[1] or share[1] < 5 * share[0]:
        return None
    axis = axes[:, 0]
    crown = quaternions.rotate(q, np.array([[0, 1.0, 0]])).mean(axis=0)
    return axis if axis @ crown >= 0 else -axis


_TILT_SHOWN_DEG = 10.0
_CONTRADICTED = "; the motion contradicts them"


def stated_facts(layout: Layout, options: TraceOptions) -> tuple[Layout, Axes]:
    """Return the layout with what options state of axes, scale and direction, and its axes.

    They come before the file and its format. Errors: InputError.
    """
    axes, said = parse_axes(layout.axes if options.axes is None else options.axes), dict[str, Any]()
    if options.pose:
        said = {"inverse": options.pose == INVERSE, "direction_by": By.USER}
    axes_by = said["axes_by"] = layout.axes_by if options.axes is None else By.USER
    if options.up is not None:
        axes = attrs.evolve(axes, tilt=parse_up(options.up))
    if options.scale is not None:
        said |= {"scale": options.scale, "scale_by": By.USER}
    elif axes.metres_per_unit is not None:
        said |= {"scale": axes.metres_per_unit, "scale_by": axes_by}
    return attrs.evolve(layout, **said), axes


def assumptions_of(r: Recording) -> tuple[Assumption, ...]:
    layout, options = r.layout, r.options
    turn, option = f"matrix {layout.matrix}", "--matrix"
    if layout.euler is not None:
        turn, option = f"angles {layout.euler.words()}", "--euler"
    elif not layout.matrix:
        turn, option = f"quaternion {layout.order}", "--quat-order"
    tilted = "" if r.axes.tilt is None else f", tilted to {options.up}"
    clock_by = By.USER if options.rate or options.time_unit else layout.unit_by
    facts = (
        Assumption(Fact.COLUMNS, columns_read(r.head, layout, r.taken), layout.columns_by, "--columns"),
        Assumption(Fact.ORIENTATION, turn, layout.order_by, option),
        Assumption(Fact.POSE, DIRECTION[layout.inverse], layout.direction_by, "--pose"),
        Assumption(Fact.LENGTH, f"{layout.scale:g} m per unit", layout.scale_by, "--scale"),
        Assumption(Fact.AXES, r.axes.label(), layout.axes_by, "--axes"),
        Assumption(Fact.UP, r.axes.up() + tilted, By.USER if tilted else layout.axes_by, "--up"),
        Assumption(Fact.CLOCK, r.time_unit, clock_by, "--time-unit"),
    )
    return tuple(fact for fact in facts if fact.what != Fact.LENGTH or r.position is not None)


def weigh_axes(r: Recording) -> None:
    """Warn where the motion contradicts axes, unit or direction of the poses.

    Errors: TraceError where only another order of the numbers than the assumed one shows a person.
    """
    layout, span = r.layout, int(r.time_ns[-1] - r.time_ns[0])
    wanted = r.time_ns[0] + np.arange(0, span + 1, max(_STEP_NS, span // _MOST_STEPS))
    at = np.unique(np.searchsorted(r.time_ns, wanted))
    t, q, p = r.time_ns[at], r.orientation[at], None if r.position is None else r.position[at] * layout.scale

    def read(q: Array, p: Array | None) -> Evidence:
        return Evidence(t, q, p, np.array(layout.gravity_down))

    evidence = read(q, p)
    if layout.order_by is By.DEFAULT and layout.euler is None:
        option, here, there = "--matrix", ROWS, COLUMNS
        turned = quaternions.conjugate(q)
        if not layout.matrix:
            option, here, there = "--quat-order", layout.order, "wxyz" if layout.order == "xyzw" else "xyzw"
            turned = np.roll(q, -1 if there == "wxyz" else 1, axis=1)
        # In any axes, or in those that the format states.
        own, other = (
            found.best_points() if layout.axes == OPENXR else found.weigh(r.axes.reading[None])[0][0]
            for found in (evidence, read(turned, p))
        )  # fmt: skip
        if other > own + CLEAR:
            what = f"its rotations, read as {option} {here}, make no person's motion; as {option} {there} they do"
            raise TraceError(f"{r.head.path}: {what}: state the one that is right")
    verdict = Verdict(evidence, r.axes)
    if p is not None:
        height_m = 0.0 if verdict.fault else float(r.axes.world[1] @ evidence.height_m)
        what, remedy = _place_fault(t, p, height_m)
        if what:
            r.found("place-implausible", None, what, remedy)
    if layout.axes_by is By.DEFAULT:
        others = "; others fit the motion nearly as well; --axes states them"
        r.shown = "; the motion agrees" if verdict.confirmed else others
    if r.options.pose is None:
        inverse = read(*inverted(q, p))
        # The inverse of a head that turns on the spot swings about the origin: each halving of
        # the way is worth a point. Of 15 recordings the inverse way is 1.2 to 19 times as long.
        shorter = math.log2(evidence.path_m / inverse.path_m) if evidence.path_m and inverse.path_m else 0.0
        gain = inverse.best_points() - evidence.best_points() + min(max(shorter, -1.5), 1.5)
        if gain > (CLEAR if verdict.fault else SURE):
            here, there = DIRECTION[::-1] if layout.inverse else DIRECTION
            better, word = Verdict(inverse, r.axes).better, DIRECT if layout.inverse else INVERSE
            axes = f" --axes '{better.name or better.words()}'" if better is not None else ""
            r.found("pose-contradicted", None, here, there, gain, word, axes)
            r.shown = _CONTRADICTED
            return
    # Where up lies between the file's axes, `report_tilt` says by how much.
    if verdict.better is not None and verdict.world_alone:
        converted = r.orientation.copy()
        r.axes.apply(None, converted)
        axis = gravity_axis(converted)
        if axis is not None and float(np.abs(axis).max()) < math.cos(math.radians(_TILT_SHOWN_DEG)):
            return
    if verdict.fault:
        r.found("axes-contradicted", None, r.axes.label(), AXES_BY[layout.axes_by], verdict.fault, verdict.advice)
        r.shown = _CONTRADICTED


def report_tilt(r: Recording) -> None:
    """Report gravity that is not along +y, judged by how the head is held."""
    # A turn of the world mends no wrong axes.
    axis = None if r.shown == _CONTRADICTED else gravity_axis(r.orientation)
    tilt = 0.0 if axis is None else float(np.degrees(np.arccos(np.clip(axis[1], -1, 1))))
    if axis is not None and tilt > _TILT_SHOWN_DEG:
        r.shown = f"; up is tilted by {tilt:.0f} degrees"
        r.found("tilt", None, ",".join(f"{a:.2f}" for a in axis), tilt)
