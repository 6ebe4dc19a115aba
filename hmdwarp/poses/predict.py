"""Where the head will be, from what was known by now."""

from __future__ import annotations

import operator
from collections.abc import Callable

import numpy as np

from ..errors import InputError
from ..geometry import Pose
from ..registry import unknown_name
from . import quaternions
from .sample import Origin, PoseSample
from .track import PoseTrack

WINDOW_NS = 50_000_000
HORIZON_NS = 100_000_000


def none(track: PoseTrack, now_ns: int, target_ns: int, horizon_ns: int) -> PoseSample:
    """The last sample known at `now_ns`, HELD."""
    i = max(track.index_at(now_ns), 0)
    exact = int(track.time_ns[i]) == target_ns
    return PoseSample(target_ns, track.pose(i), Origin.MEASURED if exact else Origin.HELD)


def constant_velocity(track: PoseTrack, now_ns: int, target_ns: int, horizon_ns: int) -> PoseSample:
    """The last sample carried on at the angular and linear velocity of the trailing 50 ms, for `horizon_ns` at most.

    Repeated poses count once and nothing is measured across a gap or jump. Where one sample is all that is known, and where the
    last one is too old to be carried on (a gap has begun), the pose is HELD.
    """
    i = track.index_at(now_ns)
    if i < 0 or now_ns - int(track.time_ns[i]) > track.max_gap_ns:
        return none(track, now_ns, target_ns, horizon_ns)
    first, last = _window(track, i)
    ahead_ns = min(target_ns - int(track.time_ns[i]), horizon_ns)
    if first == last or ahead_ns <= 0:
        return none(track, now_ns, target_ns, horizon_ns)
    q0, q1 = track.orientation_xyzw[first], track.orientation_xyzw[last]
    turn = quaternions.to_rotation_vector(quaternions.multiply(q1, quaternions.conjugate(q0)))
    share = ahead_ns / (int(track.time_ns[last]) - int(track.time_ns[first]))
    moved = track.position_m[last] + share * (track.position_m[last] - track.position_m[first])
    turned = quaternions.multiply(quaternions.from_rotation_vector(share * turn), q1)
    return PoseSample(target_ns, Pose(moved, turned), Origin.PREDICTED)


def _window(track: PoseTrack, i: int) -> tuple[int, int]:
    """First and last index of distinct poses within the 50 ms up to sample i; two samples at least if they belong together."""
    q, p = track.orientation_xyzw, track.position_m
    last = i
    while last > 0 and not track.broken[last - 1] and (q[last] == q[last - 1]).all() and (p[last] == p[last - 1]).all():
        last -= 1  # a repeated pose was measured when it first came
    # A head that has stood still for the whole window is still: its velocity is not that of long ago.
    if track.time_ns[i] - track.time_ns[last] >= WINDOW_NS:
        return i, i
    first = last
    while (
        first > 0
        and not track.broken[first - 1]
        and (first == last or track.time_ns[last] - track.time_ns[first - 1] <= WINDOW_NS)
    ):
        first -= 1
    return first, last


PREDICTORS: dict[str, Callable[[PoseTrack, int, int, int], PoseSample]] = {
    "none": none,
    "constant_velocity": constant_velocity,
    "cav": constant_velocity,
}


def predict(
    track: PoseTrack, now_ns: int, target_ns: int, method: str = "constant_velocity", horizon_ns: int = HORIZON_NS
) -> PoseSample:
    """The head at `target_ns` as it can be known at `now_ns`: no sample after `now_ns` is looked at.

    method: none or constant_velocity (cav). horizon_ns: how far ahead of the last sample at most; beyond it the pose stays where
    it is then. A target at or before the last known sample is no prediction and is looked up.
    Errors: UnknownNameError; InputError for a negative horizon.
    """
    if method not in PREDICTORS:
        raise unknown_name("predictor", method, sorted(PREDICTORS))
    if horizon_ns < 0:
        raise InputError(f"prediction horizon {horizon_ns / 1e6:g} ms: wanted 0 or more")
    now_ns, target_ns = operator.index(now_ns), operator.index(target_ns)
    i = track.index_at(now_ns)
    if i >= 0 and target_ns <= int(track.time_ns[i]):
        return track.at(target_ns)
    return PREDICTORS[method](track, now_ns, target_ns, horizon_ns)


def predict_many(track: PoseTrack, now_ns: np.ndarray, ahead_ns: int, window_ns: int = WINDOW_NS) -> np.ndarray:
    """(n, 4) orientations `ahead_ns` after each of `now_ns`, at the angular velocity of the `window_ns` before: for the tables.

    Unlike `predict` it interpolates the poses at both ends of the window, so it does not depend on where the samples lie.
    """
    q1 = track.sample_many(now_ns).orientation_xyzw
    q0 = track.sample_many(now_ns - window_ns).orientation_xyzw
    turn = quaternions.to_rotation_vector(quaternions.multiply(q1, quaternions.conjugate(q0)))
    return quaternions.multiply(quaternions.from_rotation_vector(turn * (ahead_ns / window_ns)), q1)
