"""A head's poses over time: validated samples, and the pose at any instant between them."""

from __future__ import annotations

import enum
import operator
from collections.abc import Callable, Iterable
from contextlib import suppress
from numbers import Real
from typing import Any, Protocol, runtime_checkable

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base import NO_NUMBERS, TraceError, in_brief
from ..geometry import MOST_M, Pose, trusted_pose
from . import quaternions

# An eye that turns faster leaps: pursuit is slower (Meyer, Lasker and Robinson 1985, The upper
# limit of human smooth pursuit velocity).
SACCADE_DEG_S = 100.0
SHORTEST_GAP_NS = 100_000_000
UNIT_WITHIN = 1e-2  # a file's quaternion whose length is off by more is no rotation
_UNIT_AS_IS = 1e-15  # |q|^2 off by less than this is rounding: such quaternions stay bit for bit unchanged
Gaze = tuple[float, float, float]


class Origin(enum.IntEnum):
    """How a pose was obtained; vectorised sampling stores the integers."""

    MEASURED = 0
    INTERPOLATED = 1
    PREDICTED = 2
    HELD = 3


@attrs.frozen(eq=False)
class PoseSample:
    """`pose` is world_from_head at `time_ns`, the requested instant."""

    time_ns: int
    pose: Pose
    origin: Origin
    read_ns: int | None = None  # when a live source read it from its device, on the same clock; None for recordings
    # How often the space of a live source's poses has changed, by a recentre for instance. No head
    # moves from one to the next.
    space: int = 0
    gaze: Gaze | None = None  # unit direction in the head's axes in which the eyes look; None where that is not known


def gap_limit_ns(time_ns: NDArray[np.int64]) -> int:
    """Return the longest step that is interpolated: 100 ms, or four median steps if that is more.

    Heads turn at up to 300 deg/s: 30 degrees, about the longest arc that interpolation can be
    trusted for.
    """
    return SHORTEST_GAP_NS if len(time_ns) < 2 else max(SHORTEST_GAP_NS, 4 * int(np.median(np.diff(time_ns))))


def _times(value: ArrayLike) -> NDArray[np.int64]:
    with suppress(*NO_NUMBERS):
        array = np.asarray(value)
        if array.ndim == 1 and array.dtype.kind in "iu":
            return array.astype(np.int64)
    raise TraceError(f"time_ns: expected a row of integers, found {in_brief(value)}")


def _texts(value: Iterable[str]) -> tuple[str, ...]:
    with suppress(*NO_NUMBERS):
        return tuple(map(str, value))
    raise TraceError(f"notes: expected texts, found {in_brief(value)}")


def _jumps(value: Iterable[int]) -> tuple[int, ...]:
    with suppress(*NO_NUMBERS):
        return tuple(map(int, value))
    raise TraceError(f"jumps: expected indices of samples, found {in_brief(value)}")


def _floats(value: ArrayLike) -> NDArray[np.float64]:
    """Return an array of its own: the caller's stays writeable. Errors: TraceError."""
    with suppress(*NO_NUMBERS):
        return np.array(value, dtype=np.float64)
    raise TraceError(f"expected rows of numbers, found {in_brief(value)}")


@attrs.frozen(eq=False)
class Samples:
    """Many poses at once."""

    time_ns: NDArray[np.int64]  # (n,)
    position_m: NDArray[np.float64]  # (n, 3)
    orientation_xyzw: NDArray[np.float64]  # (n, 4)
    origin: NDArray[np.int8]  # (n,) values of `Origin`


@attrs.frozen(eq=False)
class PoseTrack:
    """world_from_head over time, OpenXR axes, metres.

    Nothing is interpolated across a gap or a jump: there the last pose is HELD.

    Parameters
    ----------
    time_ns : (n,) array_like of int
        Strictly increasing.
    position_m : (n, 3) array_like
    orientation_xyzw : (n, 4) array_like
        Normalised here and made continuous in sign; off length 1 by at most 0.01.
    name, origin, axes : str
        `origin` says where the motion comes from, `axes` what a file's were, who says so, and what
        the motion shows; "" without a file.
    notes : iterable of str
    epoch_ns : int
        The file's own time at time 0 of this track.
    max_gap_ns : int
        Longer steps are gaps; by default 100 ms, or four median steps if that is more.
    jumps : iterable of int
        Indices i with a teleport between samples i and i + 1.
    gaze : (n, 3) array_like, optional
        Unit directions in the head's axes in which the eyes look, NaN where that is not known.

    Raises
    ------
    TraceError
        Naming the first sample that breaks a rule.
    """

    time_ns: NDArray[np.int64] = attrs.field(converter=_times)
    position_m: NDArray[np.float64] = attrs.field(converter=_floats)
    orientation_xyzw: NDArray[np.float64] = attrs.field(converter=_floats)
    name: str = ""
    origin: str = ""
    axes: str = ""
    notes: tuple[str, ...] = attrs.field(default=(), converter=_texts)
    epoch_ns: int = 0
    max_gap_ns: int = attrs.field(default=attrs.Factory(lambda self: gap_limit_ns(self.time_ns), takes_self=True))
    jumps: tuple[int, ...] = attrs.field(default=(), converter=_jumps)
    gaze: NDArray[np.float64] | None = attrs.field(default=None, converter=attrs.converters.optional(_floats))
    # (n - 1,) whether a gap or jump follows each sample
    broken: NDArray[np.bool_] = attrs.field(init=False, repr=False)

    def __attrs_post_init__(self) -> None:
        n, steps = len(self.time_ns), np.diff(self.time_ns)
        if n == 0:
            raise TraceError("a head track needs at least one sample")
        if self.position_m.shape != (n, 3) or self.orientation_xyzw.shape != (n, 4):
            shapes = f"{self.position_m.shape} and {self.orientation_xyzw.shape}"
            raise TraceError(f"{n} instants with poses of shape {shapes}: expected ({n}, 3) and ({n}, 4)")
        if n > 1 and steps.min() <= 0:
            i = int(np.argmax(steps <= 0))
            a, b = self.time_ns[i : i + 2]
            raise TraceError(f"time_ns does not increase at sample {i + 1}: {a} then {b}")
        for array in (self.position_m, self.orientation_xyzw):
            if not np.isfinite(array).all():
                i = int(np.argmin(np.isfinite(array).all(axis=1)))
                raise TraceError(f"sample {i} of the head track is not finite: {array[i].tolist()}")
        if (far := np.abs(self.position_m).max(axis=1)).max() > MOST_M:
            i = int(np.argmax(far))
            raise TraceError(f"sample {i} of the head track is {far[i]:g} m away: expected at most {MOST_M:g} m")
        if not isinstance(self.max_gap_ns, Real):
            raise TraceError(f"max_gap_ns: expected nanoseconds, found {in_brief(self.max_gap_ns)}")
        if any(not 0 <= i < n - 1 for i in self.jumps):
            raise TraceError(f"jumps {self.jumps}: expected indices of samples that have a next one, 0 to {n - 2}")
        broken = steps > self.max_gap_ns
        broken[list(self.jumps)] = True
        made = {"orientation_xyzw": _unit_and_continuous(self.orientation_xyzw), "broken": broken}
        for name, value in (made | {"gaze": None if self.gaze is None else _unit_gaze(self.gaze, n)}).items():
            object.__setattr__(self, name, value)
        for array in (self.time_ns, self.position_m, self.orientation_xyzw, self.broken, self.gaze):
            if array is not None:
                array.flags.writeable = False

    def __len__(self) -> int:
        return len(self.time_ns)

    def __repr__(self) -> str:
        span = f"{self.duration_ns * 1e-9:.2f} s at {self.rate_hz:.1f} Hz"
        return f"<PoseTrack '{self.name}': {len(self)} poses in {span}>"

    @property
    def start_ns(self) -> int:
        """Instant of the first sample."""
        return int(self.time_ns[0])

    @property
    def end_ns(self) -> int:
        """Instant of the last sample."""
        return int(self.time_ns[-1])

    @property
    def duration_ns(self) -> int:
        """From the first sample to the last."""
        return self.end_ns - self.start_ns

    @property
    def rate_hz(self) -> float:
        """One over the median step; 0 for a single sample."""
        return 1e9 / float(np.median(np.diff(self.time_ns))) if len(self) > 1 else 0.0

    def index_at(self, time_ns: int) -> int:
        """Return the index of the last sample at or before `time_ns`; -1 before the first."""
        time_ns, times = operator.index(time_ns), self.time_ns
        if time_ns < times[0]:
            return -1
        return len(times) - 1 if time_ns >= times[-1] else int(times.searchsorted(time_ns, side="right")) - 1

    def pose(self, index: int) -> Pose:
        return Pose(self.position_m[index], self.orientation_xyzw[index])

    def at(self, time_ns: int) -> PoseSample:
        """Return the head at an instant (ns): SLERP and linear between two samples.

        On a sample: MEASURED. Between two: INTERPOLATED. Before the first, after the last and
        within a gap or jump: HELD at the nearest end or the last sample before.
        """
        time_ns, gaze = operator.index(time_ns), None if self.gaze is None else self.gaze_at(time_ns)
        i = self.index_at(time_ns)
        if i < 0:
            return PoseSample(time_ns, self.pose(0), Origin.HELD, gaze=gaze)
        t0, *t1 = self.time_ns[i : i + 2].tolist()
        if t0 == time_ns:
            return PoseSample(time_ns, self.pose(i), Origin.MEASURED, gaze=gaze)
        if not t1 or self.broken[i]:
            return PoseSample(time_ns, self.pose(i), Origin.HELD, gaze=gaze)
        share = (time_ns - t0) / (t1[0] - t0)
        a, b = self.orientation_xyzw[i : i + 2].tolist()
        (x, y, z), (u, v, w) = self.position_m[i : i + 2].tolist()
        position = np.array((x + share * (u - x), y + share * (v - y), z + share * (w - z)))
        pose = trusted_pose(position, quaternions.slerp(a, b, share))
        return PoseSample(time_ns, pose, Origin.INTERPOLATED, gaze=gaze)

    def gaze_at(self, time_ns: int) -> Gaze | None:
        """Return where the eyes look: linear between two samples, else the last known.

        Held where the eyes leap or blink and within a gap or jump; None before the first known.
        """
        i = self.index_at(time_ns)
        if self.gaze is None or i < 0:
            return None
        a, *b = self.gaze[i : i + 2]
        if b and not self.broken[i] and np.isfinite(a + b[0]).all():
            step = int(self.time_ns[i + 1] - self.time_ns[i])
            if np.degrees(np.arccos(min(1.0, float(a @ b[0])))) <= SACCADE_DEG_S * step * 1e-9:
                a = a + (time_ns - int(self.time_ns[i])) / step * (b[0] - a)
        while not np.isfinite(a).all():
            if not i:
                return None
            i -= 1
            a = self.gaze[i]
        x, y, z = (a / np.linalg.norm(a)).tolist()
        return x, y, z

    def sample_many(self, time_ns: ArrayLike) -> Samples:
        """Return `at` for many instants (n,) at once, by the same rules."""
        instants = _times(time_ns)
        i = np.clip(np.searchsorted(self.time_ns, instants, side="right") - 1, 0, len(self) - 1)
        j = np.minimum(i + 1, len(self) - 1)
        inside = (instants >= self.start_ns) & (j > i)
        if len(self) > 1:
            inside &= ~self.broken[np.minimum(i, len(self) - 2)]
        step = np.where(j > i, self.time_ns[j] - self.time_ns[i], 1)
        share = np.where(inside, (instants - self.time_ns[i]) / step, 0.0)
        exact = instants == self.time_ns[i]
        origin = np.where(exact, Origin.MEASURED, np.where(inside, Origin.INTERPOLATED, Origin.HELD)).astype(np.int8)
        p = self.position_m[i]
        position = p + share[:, None] * (self.position_m[j] - p)
        q = quaternions.slerp_many(self.orientation_xyzw[i], self.orientation_xyzw[j], share)
        q[share == 0] = self.orientation_xyzw[i[share == 0]]
        return Samples(instants, position, q / np.linalg.norm(q, axis=1, keepdims=True), origin)

    def run_of(self, time_ns: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the number, (n,), of gaps and jumps before the last sample at each instant."""
        i = np.clip(np.searchsorted(self.time_ns, time_ns, side="right") - 1, 0, len(self) - 1)
        return np.concatenate([[0], np.cumsum(self.broken)])[i]

    def without_repeats(self) -> PoseTrack:
        """Return the motion without repeats of slow trackers: to differentiate, not replay."""
        new = np.ones(len(self), bool)
        new[1:] = (self.orientation_xyzw[1:] != self.orientation_xyzw[:-1]).any(axis=1)
        new[1:] |= (self.position_m[1:] != self.position_m[:-1]).any(axis=1)
        if new.all():
            return self
        keep = np.flatnonzero(new)
        # A jump after sample i moves to the next pose that is kept.
        jumps = set(np.searchsorted(keep, np.asarray(self.jumps, dtype=np.int64), side="right") - 1) - {len(keep) - 1}
        return self.evolve(
            time_ns=self.time_ns[keep], position_m=self.position_m[keep], orientation_xyzw=self.orientation_xyzw[keep],
            jumps=sorted(jumps),
        )  # fmt: skip

    def evolve(self, **changes: Any) -> PoseTrack:
        """Return a copy with changes; gap limit and gaze are left behind by other samples."""
        if len(changes.get("time_ns", self.time_ns)) != len(self):
            changes = {"gaze": None, **changes}
        fields = (f.name for f in attrs.fields(PoseTrack) if f.name not in ("max_gap_ns", "broken"))
        return PoseTrack(**{name: getattr(self, name) for name in fields} | changes)


def _unit_gaze(gaze: NDArray[np.float64], n: int) -> NDArray[np.float64]:
    if gaze.shape != (n, 3):
        raise TraceError(f"{n} instants with gaze of shape {gaze.shape}: expected ({n}, 3)")
    squared = np.einsum("ij,ij->i", gaze, gaze)
    with np.errstate(invalid="ignore"):  # of length 0
        found = np.where((np.abs(squared - 1) > _UNIT_AS_IS)[:, None], gaze / np.sqrt(squared)[:, None], gaze)
    if not np.isfinite(found[np.isfinite(gaze).any(axis=1)]).all():
        raise TraceError("a gaze that is no direction: expected three finite numbers, or NaN where it is not known")
    return np.asarray(found)


def _unit_and_continuous(q: NDArray[np.float64]) -> NDArray[np.float64]:
    norm_squared = np.einsum("ij,ij->i", q, q)
    off = np.abs(norm_squared - 1)
    worst = int(np.argmax(off))
    if not abs(np.sqrt(norm_squared[worst]) - 1) <= UNIT_WITHIN:
        length = np.sqrt(norm_squared[worst])
        found = f"a quaternion of length {length:.4g}, expected 1 within {UNIT_WITHIN:g}"
        raise TraceError(f"sample {worst}: {found}: {q[worst].tolist()}")
    if off[worst] > _UNIT_AS_IS:
        q = q / np.where(off > _UNIT_AS_IS, np.sqrt(norm_squared), 1.0)[:, None]
    quaternions.make_continuous(q)
    return q


@runtime_checkable
class PoseSource(Protocol):
    """A source of head poses: a recording, a mouse, a headset."""

    def start(self) -> None:
        """Prepare; called once before the first `head_at`. Nothing by default."""
        return

    def head_at(self, time_ns: int) -> PoseSample:
        """Return world_from_head at an instant of this source's clock."""

    def close(self) -> None:
        """Release devices; safe to call twice. Nothing by default."""
        return


class RecordedSource(PoseSource):
    """A recorded track as a source: the same instant always gives the same pose."""

    def __init__(self, track: PoseTrack) -> None:
        self.track = track

    def head_at(self, time_ns: int) -> PoseSample:
        """Return `PoseTrack.at`: interpolated, HELD outside the recording and within its gaps."""
        return self.track.at(time_ns)


class LoopedSource(RecordedSource):
    """A PoseSource over a track on the clock `now_ns`, to its end and back, endlessly."""

    def __init__(self, track: PoseTrack, now_ns: Callable[[], int]) -> None:
        super().__init__(track)
        self._now_ns, self._begun_ns, self._begun = now_ns, now_ns(), 0

    def restart(self) -> None:
        """Begin the track at this instant."""
        self._begun_ns, self._begun = self._now_ns(), self._begun + 1

    def head_at(self, time_ns: int) -> PoseSample:
        """Return the track's pose; read_ns: the clock now; space: how often it has begun again."""
        sample = self.track.at(self.track.start_ns + self.moment(time_ns).since_ns)  # its first, before its beginning
        return attrs.evolve(sample, time_ns=time_ns, read_ns=self._now_ns(), space=self._begun)

    def moment(self, time_ns: int) -> Moment:
        """Return where the recording is at an instant of the clock."""
        return folded(time_ns - self._begun_ns, self.track.duration_ns)


@attrs.frozen
class Moment:
    """An instant of a recording that is played, since its beginning."""

    since_ns: int
    is_backwards: bool = False


def folded(since_ns: int, length_ns: int) -> Moment:
    """Return 0 to length and back again, endlessly; 0 before the beginning."""
    if since_ns <= 0 or length_ns <= 0:
        return Moment(0)
    turn, at_ns = divmod(since_ns, length_ns)
    return Moment(length_ns - at_ns, True) if turn % 2 else Moment(at_ns)
