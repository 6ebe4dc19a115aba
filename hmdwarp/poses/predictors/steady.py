"""Predictors without a judgement: the last pose is held, or its velocity goes on."""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

from ...geometry import Pose
from .. import quaternions
from ..track import Origin, PoseSample, PoseTrack, Samples
from . import Predictor, hold, predictors

WINDOW_NS = 50_000_000
HORIZON_NS = 100_000_000


def constant_velocity(track: PoseTrack, now_ns: int, target_ns: int, horizon_ns: int) -> PoseSample:
    """Extrapolate the last sample at the angular and linear velocity of the trailing 50 ms.

    At most `horizon_ns` ahead. Repeated poses count once, and no velocity is measured across a gap
    or jump. With a single known sample, or when a gap has begun since the last one, the pose is
    HELD.
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
    share = min(ahead_ns, HORIZON_NS) / WINDOW_NS
    then, now = track.sample_many(now_ns - WINDOW_NS), track.sample_many(now_ns)
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
    if track.time_ns[i] - track.time_ns[last] >= WINDOW_NS:
        return i, i
    first = last
    earliest = min(int(track.time_ns[last]) - WINDOW_NS, int(track.time_ns[max(last - 1, 0)]))
    while first > 0 and not track.broken[first - 1] and track.time_ns[first - 1] >= earliest:
        first -= 1
    return first, last


predictors.register(Predictor(
    "none", "the last known pose is held", "the baseline of every predictor", hold,
    lambda track, now_ns, ahead_ns: attrs.evolve(track.sample_many(now_ns), time_ns=now_ns + ahead_ns),
))  # fmt: skip
_steady = predictors.register(Predictor(
    "constant_velocity", "angular and linear velocity of the last 50 ms go on",
    "LaValle et al. 2014, Head tracking for the Oculus Rift: prediction at a constant angular rate",
    constant_velocity, _steady_many, HORIZON_NS,
))  # fmt: skip
# The literature's short name, of constant angular velocity.
predictors.register(attrs.evolve(_steady, name="cav", alias_of=_steady.name))
