"""Errs short: a speed that fades, and counts for less where it has just failed to foretell.

A prediction that leads the head overshoots where the head stops, and has to come back. So the speed
of the last moments fades with time, is followed for a limited horizon only, and is scaled by a
confidence. That comes from the predictor's own record: what the same speed a few moments ago
foretold for now, against what the head did. What it foretold too far counts more.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence

import attrs
import numpy as np
from numpy.typing import NDArray

from ...geometry import Pose, trusted_pose
from .. import quaternions
from ..track import Origin, PoseSample, PoseTrack, Samples, gap_limit_ns
from . import Predictor, hold, predictors

Array = NDArray[np.float64]

_MS = 1_000_000
WINDOW_NS = 30 * _MS  # that the speed is measured over
# Past predictions looked this far ahead, and ended this long ago. Longer ones react too late to a
# head that slows down; a single one is at the mercy of a tracker's noise.
TESTED_NS = 50 * _MS
ENDED_NS = (0, 20 * _MS, 40 * _MS)
# Fitted to 57 recordings of 19 people (EyeNavGS, Rutgers site: Ding et al. 2025, arXiv:2506.02380):
# the least mean error plus ten times the mean lead, from 50 to 800 ms and each as a share of the
# motion, among those that lead less than constant_velocity at each latency, and whose p95 error is
# at most 1 % more in nine of ten recordings.
FADES_NS = 200 * _MS  # time constant of turning
HORIZON_NS = 150 * _MS
MOVES_NS = 105 * _MS  # walking does not fade: it goes on for this long
WEIGHT_MISSED, WEIGHT_TOO_FAR = 0.25, 4.0  # of the squared errors of the past predictions

KNOWN_NS = max(ENDED_NS) + TESTED_NS + WINDOW_NS
_ENDED, _COUNT = np.array(ENDED_NS, np.int64), len(ENDED_NS)
# Before now: the two ends of the window, and of each past prediction now, then, and its window's.
_BACK_NS = np.concatenate([(0, WINDOW_NS), _ENDED, _ENDED + TESTED_NS, _ENDED + TESTED_NS + WINDOW_NS])
_BACK = tuple(_BACK_NS.tolist())
# From which of these to which: the last window, those of the past predictions, what came of them.
_WAYS = (
    (1, 0), *((2 + 2 * _COUNT + i, 2 + _COUNT + i) for i in range(_COUNT)),
    *((2 + _COUNT + i, 2 + i) for i in range(_COUNT)),
)  # fmt: skip


def turns_ns(ahead_ns: int) -> float:
    """Return how long the full speed would last to turn as far as the fading one does."""
    return -FADES_NS * float(np.expm1(-ahead_ns / FADES_NS))


def confidence(moving: Array, missed: Array) -> Array:
    """Return 0..1: how far to trust a motion, (n,).

    moving: what the present speed foretells for TESTED_NS, (n, 3), rotation vector or way. missed:
    by how much the last predictions for as long came out too far, (n, k, 3). 1 where they were
    right; the units do not matter.
    """
    squared = np.einsum("ni,ni->n", moving, moving)[:, None]
    moves = squared > 0
    along = np.maximum(np.einsum("nki,ni->nk", missed, moving), 0.0)
    too_far = along * (along / np.where(moves, squared, 1.0))
    doubt = WEIGHT_MISSED * np.einsum("nki,nki->nk", missed, missed) + WEIGHT_TOO_FAR * too_far
    total = squared[:, 0] + doubt.mean(axis=1)
    return np.asarray(squared[:, 0] / np.where(total > 0, total, 1.0))


def cautious(track: PoseTrack, now_ns: int, target_ns: int, horizon_ns: int) -> PoseSample:
    """Extrapolate the last sample at most `horizon_ns` ahead; HELD where no speed is known.

    That takes a whole window without a gap or jump. Repeated poses count once; a head that repeats
    its pose for TESTED_NS rests.
    """
    i = track.index_at(now_ns)
    last_ns = int(track.time_ns[i])
    ahead_ns = min(target_ns - last_ns, horizon_ns)
    if i < 0 or now_ns - last_ns > track.max_gap_ns or ahead_ns <= 0:
        return hold(track, now_ns, target_ns, horizon_ns)
    recent = _recent(track, i)
    end_ns = recent.time_ns[-1]
    if end_ns - recent.time_ns[0] < WINDOW_NS or last_ns - end_ns >= TESTED_NS:
        return hold(track, now_ns, target_ns, horizon_ns)
    return PoseSample(target_ns, _followed(recent, ahead_ns), Origin.PREDICTED)


@attrs.frozen
class _Recent:
    """The last distinct poses, in plain floats: for one prediction quicker than arrays."""

    time_ns: list[int]
    positions_m: list[list[float]]
    orientations_xyzw: list[list[float]]
    limit_ns: int  # longer steps are gaps

    def at(self, time_ns: int) -> tuple[list[float], list[float]]:
        """Return position and orientation, by the rules of `PoseTrack.at`."""
        times = self.time_ns
        i = max(bisect_right(times, time_ns) - 1, 0)
        p, q = self.positions_m[i], self.orientations_xyzw[i]
        if times[i] >= time_ns or i + 1 == len(times) or times[i + 1] - times[i] > self.limit_ns:
            return p, q
        share = (time_ns - times[i]) / (times[i + 1] - times[i])
        (x, y, z), (u, v, w) = p, self.positions_m[i + 1]
        position = [x + share * (u - x), y + share * (v - y), z + share * (w - z)]
        return position, quaternions.slerp(q, self.orientations_xyzw[i + 1], share)


def _recent(track: PoseTrack, i: int) -> _Recent:
    """Return the distinct poses up to sample i that are looked at, each at its first stamp."""
    first = max(track.index_at(int(track.time_ns[i]) - KNOWN_NS - TESTED_NS), 0)
    breaks = track.broken[first:i].nonzero()[0]
    first = first + int(breaks[-1]) + 1 if len(breaks) else first
    times, p = track.time_ns[first : i + 1].tolist(), track.position_m[first : i + 1].tolist()
    q = track.orientation_xyzw[first : i + 1].tolist()
    new = [k for k in range(len(times)) if k == 0 or q[k] != q[k - 1] or p[k] != p[k - 1]]
    if len(new) == len(times):
        return _Recent(times, p, q, track.max_gap_ns)
    times = [times[k] for k in new]
    return _Recent(times, [p[k] for k in new], [q[k] for k in new], gap_limit_ns(np.array(times)))


def _followed(recent: _Recent, ahead_ns: int) -> Pose:
    """Extrapolate the last pose: `_cautious_many` for a single instant."""
    times, i = recent.time_ns, len(recent.time_ns) - 1
    now_ns = times[i]
    while i and times[i] - times[i - 1] <= recent.limit_ns:
        i -= 1
    first_ns = times[i]
    heads: dict[int, tuple[list[float], list[float]]] = {}
    places, turns, known, turned, moved = [], [], [], [], []
    for back in _BACK:
        if back not in heads:
            heads[back] = recent.at(now_ns - back)
        places.append(heads[back][0])
        turns.append(heads[back][1])
        known.append(now_ns - back >= first_ns)
    for first, last in _WAYS:
        a, b = places[first], places[last]
        moved.append((b[0] - a[0], b[1] - a[1], b[2] - a[2]))
        turned.append(quaternions.turn(turns[first], turns[last]))
    (u, v, w), (x, y, z), place = _trusted_one(turned, known), _trusted_one(moved, known), places[0]
    angle, length = turns_ns(ahead_ns) / WINDOW_NS, min(ahead_ns, MOVES_NS) / WINDOW_NS
    position = np.array([place[0] + length * x, place[1] + length * y, place[2] + length * z])
    return trusted_pose(position, quaternions.turned(turns[0], (angle * u, angle * v, angle * w)))


def _trusted_one(ways: Sequence[Sequence[float]], known: Sequence[bool]) -> tuple[float, float, float]:
    """Return `_trusted` of one motion: ways between _WAYS, known at each of _BACK."""
    x, y, z = ways[0]
    if not known[1]:
        return 0.0, 0.0, 0.0
    share = TESTED_NS / WINDOW_NS
    fx, fy, fz = share * x, share * y, share * z
    squared = fx * fx + fy * fy + fz * fz
    if squared == 0:
        return 0.0, 0.0, 0.0
    doubt = 0.0
    for i in range(_COUNT):
        mx, my, mz = fx, fy, fz
        if known[2 + 2 * _COUNT + i]:
            (ux, uy, uz), (vx, vy, vz) = ways[1 + i], ways[1 + _COUNT + i]
            mx, my, mz = share * ux - vx, share * uy - vy, share * uz - vz
        along = max(mx * fx + my * fy + mz * fz, 0.0)
        doubt += WEIGHT_MISSED * (mx * mx + my * my + mz * mz) + WEIGHT_TOO_FAR * (along * (along / squared))
    trust = squared / (squared + doubt / _COUNT)
    return trust * x, trust * y, trust * z


def _cautious_many(track: PoseTrack, now_ns: NDArray[np.int64], ahead_ns: int) -> Samples:
    """Extrapolate from each of `now_ns`, (n,)."""
    ahead_ns = min(ahead_ns, HORIZON_NS)
    instants = now_ns[:, None] - _BACK_NS
    found = track.sample_many(instants.ravel())
    q, p = found.orientation_xyzw.reshape(*instants.shape, 4), found.position_m.reshape(*instants.shape, 3)
    runs = track.run_of(instants.ravel()).reshape(instants.shape)
    known = (runs == runs[:, :1]) & (instants >= track.start_ns)

    def turn(first: slice, last: slice) -> Array:
        return quaternions.vector_between(q[:, first], q[:, last])

    def move(first: slice, last: slice) -> Array:
        return p[:, last] - p[:, first]

    turned = quaternions.from_rotation_vector(turns_ns(ahead_ns) / WINDOW_NS * _trusted(turn, known))
    return Samples(
        now_ns + ahead_ns, p[:, 0] + min(ahead_ns, MOVES_NS) / WINDOW_NS * _trusted(move, known),
        quaternions.multiply(turned, q[:, 0]), np.full(len(now_ns), Origin.PREDICTED, np.int8),
    )  # fmt: skip


def _trusted(way: Callable[[slice, slice], Array], known: NDArray[np.bool_]) -> Array:
    """Return the motion within the last window scaled by its confidence, (n, 3).

    way(first, last): between the poses at these places of _BACK_NS, (n, k, 3). known: where there
    are poses, (n, 2 + 3 k). A prediction from before what is known counts as wrong by its whole
    length.
    """
    now, before = slice(0, 1), slice(1, 2)
    ended, began, window = (slice(2 + i * _COUNT, 2 + (i + 1) * _COUNT) for i in range(3))
    share = TESTED_NS / WINDOW_NS
    moved = way(before, now)
    missed = np.where(known[:, window, None], share * way(window, began) - way(began, ended), share * moved)
    trust = confidence(share * moved[:, 0], missed)
    return np.where(known[:, before], trust[:, None] * moved[:, 0], 0.0)


_cautious = predictors.register(Predictor(
    "cautious", "the speed of the last 30 ms fades, the sooner the more it has just overshot",
    "Gardner and McKenzie 1985, Forecasting Trends in Time Series: a damped trend; the confidence is our own",
    cautious, _cautious_many, HORIZON_NS,
))  # fmt: skip
# For those who do not choose one.
predictors.register(attrs.evolve(_cautious, name="on", alias_of=_cautious.name))
