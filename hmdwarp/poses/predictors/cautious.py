"""Errs short: a speed that fades, and counts for less where it has just failed to foretell.

A prediction that leads the head overshoots where the head stops, and has to come back. So the speed
of the last moments fades with time, is followed for a limited horizon only, and is scaled by a
confidence. That comes from the predictor's own record: what the same speed a few moments ago
foretold for now, against what the head did. What it foretold too far counts more.
"""

from __future__ import annotations

from bisect import bisect_right

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
_COUNT = len(ENDED_NS)
# Before now: the two ends of the window, and of each past prediction now, then, and its window's.
_BACK_NS = (0, WINDOW_NS, *(ended + back for back in (0, TESTED_NS, TESTED_NS + WINDOW_NS) for ended in ENDED_NS))
# From which of these to which: the last window, those of the past predictions, what came of them.
_FROM = (1, *range(2 + 2 * _COUNT, 2 + 3 * _COUNT), *range(2 + _COUNT, 2 + 2 * _COUNT))
_TO = (0, *range(2 + _COUNT, 2 + 2 * _COUNT), *range(2, 2 + _COUNT))


def _turns_ns(ahead_ns: int) -> float:
    """Return how long the full speed would last to turn as far as the fading one does."""
    return -FADES_NS * float(np.expm1(-ahead_ns / FADES_NS))


def _trusted(ways: Array, known: NDArray[np.bool_]) -> Array:
    """Return the first way of those from _FROM to _TO, (.., 3), as far as it is to be trusted."""
    share, windows, came = TESTED_NS / WINDOW_NS, ways[1 : 1 + _COUNT], ways[1 + _COUNT :]
    moving = share * ways[0]
    # known: at _BACK_NS, (2 + 3 k, ..). A prediction from before that is wrong by its whole length.
    missed = np.where(known[2 + 2 * _COUNT :, ..., None], share * windows - came, moving)
    squared = (moving * moving).sum(axis=-1)
    along = np.maximum((missed * moving).sum(axis=-1), 0.0)
    too_far = along * along / np.where(squared > 0, squared, 1.0)
    doubt = WEIGHT_MISSED * (missed * missed).sum(axis=-1) + WEIGHT_TOO_FAR * too_far
    total = squared + doubt.mean(axis=0)
    trust = np.where(known[1], squared / np.where(total > 0, total, 1.0), 0.0)
    return np.asarray(trust[..., None] * ways[0])


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
    times, places, turns, limit_ns = _recent(track, i)
    if times[-1] - times[0] < WINDOW_NS or last_ns - times[-1] >= TESTED_NS:
        return hold(track, now_ns, target_ns, horizon_ns)

    def at(time_ns: int) -> tuple[list[float], list[float]]:
        """Return position and orientation, by the rules of `PoseTrack.at`, but quicker."""
        k = max(bisect_right(times, time_ns) - 1, 0)
        if times[k] >= time_ns or k + 1 == len(times) or times[k + 1] - times[k] > limit_ns:
            return places[k], turns[k]
        share = (time_ns - times[k]) / (times[k + 1] - times[k])
        (x, y, z), (u, v, w) = places[k : k + 2]
        position = [x + share * (u - x), y + share * (v - y), z + share * (w - z)]
        return position, quaternions.slerp(turns[k], turns[k + 1], share)

    begin = len(times) - 1  # of the last run without a gap
    while begin and times[begin] - times[begin - 1] <= limit_ns:
        begin -= 1
    heads = {back: at(times[-1] - back) for back in set(_BACK_NS)}
    known = np.array([times[-1] - back >= times[begin] for back in _BACK_NS])
    p, q = np.array([heads[back][0] for back in _BACK_NS]), [heads[back][1] for back in _BACK_NS]
    turned = np.array([quaternions.turn(q[a], q[b]) for a, b in zip(_FROM, _TO, strict=True)])
    turn = _turns_ns(ahead_ns) / WINDOW_NS * _trusted(turned, known)
    moved = min(ahead_ns, MOVES_NS) / WINDOW_NS * _trusted(p[_TO, :] - p[_FROM, :], known)
    pose = trusted_pose(p[0] + moved, quaternions.turned(q[0], turn.tolist()))
    return PoseSample(target_ns, pose, Origin.PREDICTED)


def _recent(track: PoseTrack, i: int) -> tuple[list[int], list[list[float]], list[list[float]], int]:
    """Return the distinct poses up to sample i, each at its first stamp, and the longest step."""
    first = max(track.index_at(int(track.time_ns[i]) - KNOWN_NS - TESTED_NS), 0)
    breaks = track.broken[first:i].nonzero()[0]
    first = first + int(breaks[-1]) + 1 if len(breaks) else first
    times, p = track.time_ns[first : i + 1].tolist(), track.position_m[first : i + 1].tolist()
    q = track.orientation_xyzw[first : i + 1].tolist()
    new = [k for k in range(len(times)) if k == 0 or q[k] != q[k - 1] or p[k] != p[k - 1]]
    if len(new) == len(times):
        return times, p, q, track.max_gap_ns
    times = [times[k] for k in new]
    return times, [p[k] for k in new], [q[k] for k in new], gap_limit_ns(np.array(times))


def _cautious_many(track: PoseTrack, now_ns: NDArray[np.int64], ahead_ns: int) -> Samples:
    ahead_ns = min(ahead_ns, HORIZON_NS)
    instants = now_ns - np.array(_BACK_NS)[:, None]
    found = track.sample_many(instants.ravel())
    q, p = found.orientation_xyzw.reshape(*instants.shape, 4), found.position_m.reshape(*instants.shape, 3)
    runs = track.run_of(instants.ravel()).reshape(instants.shape)
    known = (runs == runs[0]) & (instants >= track.start_ns)
    turned = _trusted(quaternions.vector_between(q[_FROM, :], q[_TO, :]), known)
    moved = min(ahead_ns, MOVES_NS) / WINDOW_NS * _trusted(p[_TO, :] - p[_FROM, :], known)
    turn = quaternions.from_rotation_vector(_turns_ns(ahead_ns) / WINDOW_NS * turned)
    predicted = np.full(len(now_ns), Origin.PREDICTED, np.int8)
    return Samples(now_ns + ahead_ns, p[0] + moved, quaternions.multiply(turn, q[0]), predicted)


predictors.register(Predictor(
    "cautious", "the speed of the last 30 ms fades, the sooner the more it has just overshot",
    "Gardner and McKenzie 1985, Forecasting Trends in Time Series: a damped trend; the confidence is our own",
    cautious, _cautious_many, HORIZON_NS,
))  # fmt: skip


# Of constant_velocity.
_STEADY_WINDOW_NS, _STEADY_HORIZON_NS = 50_000_000, 100_000_000


def constant_velocity(track: PoseTrack, now_ns: int, target_ns: int, horizon_ns: int) -> PoseSample:
    """Extrapolate the last sample at the velocity of the trailing 50 ms, none across a gap or jump.

    HELD with a single known sample, or when a gap has begun since the last one.
    """
    i = track.index_at(now_ns)
    if i < 0 or now_ns - int(track.time_ns[i]) > track.max_gap_ns:
        return hold(track, now_ns, target_ns, horizon_ns)
    first, last = _window(track, i)
    ahead_ns = min(target_ns - int(track.time_ns[i]), horizon_ns)
    if first == last or ahead_ns <= 0:
        return hold(track, now_ns, target_ns, horizon_ns)
    q0, q1 = track.orientation_xyzw[first], track.orientation_xyzw[last]
    turn = quaternions.vector_between(q0, q1)
    share = ahead_ns / (int(track.time_ns[last]) - int(track.time_ns[first]))
    moved = track.position_m[last] + share * (track.position_m[last] - track.position_m[first])
    turned = quaternions.multiply(quaternions.from_rotation_vector(share * turn), q1)
    return PoseSample(target_ns, Pose(moved, turned), Origin.PREDICTED)


def _steady_many(track: PoseTrack, now_ns: NDArray[np.int64], ahead_ns: int) -> Samples:
    """Interpolate the poses at both ends of the window, so that no result depends on the stamps."""
    share = min(ahead_ns, _STEADY_HORIZON_NS) / _STEADY_WINDOW_NS
    then, now = track.sample_many(now_ns - _STEADY_WINDOW_NS), track.sample_many(now_ns)
    q0, q1 = then.orientation_xyzw, now.orientation_xyzw
    turn = quaternions.vector_between(q0, q1)
    turned = quaternions.multiply(quaternions.from_rotation_vector(share * turn), q1)
    moved = now.position_m + share * (now.position_m - then.position_m)
    return Samples(now_ns + ahead_ns, moved, turned, np.full(len(now_ns), Origin.PREDICTED, np.int8))


def _window(track: PoseTrack, i: int) -> tuple[int, int]:
    """Return the first and last of the distinct poses of the 50 ms up to sample i, two at least."""
    q, p = track.orientation_xyzw, track.position_m
    last = i
    while last > 0 and not track.broken[last - 1] and (q[last] == q[last - 1]).all() and (p[last] == p[last - 1]).all():
        last -= 1  # a repeated pose was measured at its first occurrence
    # A head that has been still for the whole window has no velocity; an older one does not count.
    if track.time_ns[i] - track.time_ns[last] >= _STEADY_WINDOW_NS:
        return i, i
    first = last
    earliest = min(int(track.time_ns[last]) - _STEADY_WINDOW_NS, int(track.time_ns[max(last - 1, 0)]))
    while first > 0 and not track.broken[first - 1] and track.time_ns[first - 1] >= earliest:
        first -= 1
    return first, last


predictors.register(Predictor(
    "none", "the last known pose is held", "the baseline of every predictor", hold,
    lambda track, now_ns, ahead_ns: attrs.evolve(track.sample_many(now_ns), time_ns=now_ns + ahead_ns),
))  # fmt: skip
predictors.register(Predictor(
    "constant_velocity", "angular and linear velocity of the last 50 ms go on",
    "LaValle et al. 2014, Head tracking for the Oculus Rift: prediction at a constant angular rate",
    constant_velocity, _steady_many, _STEADY_HORIZON_NS,
))  # fmt: skip
