"""Prediction of the head pose from past motion."""

from __future__ import annotations

import operator

import numpy as np

from ..errors import InputError
from . import quaternions
from .predictors import predictors
from .predictors.constant_velocity import WINDOW_NS
from .sample import PoseSample
from .track import PoseTrack

HORIZON_NS = 100_000_000


def predict(
    track: PoseTrack, now_ns: int, target_ns: int, method: str = "constant_velocity", horizon_ns: int = HORIZON_NS
) -> PoseSample:
    """Return the head pose at `target_ns` as known at `now_ns`; ignore every sample after `now_ns`.

    method: name of a predictor. horizon_ns: how far ahead of the last sample at most; beyond it the
    pose stays constant. A target at or before the last known sample is looked up, not predicted.
    Errors: UnknownNameError; InputError for a negative horizon.
    """
    predictor = predictors.get(method)
    if horizon_ns < 0:
        raise InputError(f"prediction horizon {horizon_ns / 1e6:g} ms: expected 0 or more")
    now_ns, target_ns = operator.index(now_ns), operator.index(target_ns)
    i = track.index_at(now_ns)
    if i >= 0 and target_ns <= int(track.time_ns[i]):
        return track.at(target_ns)
    return predictor.predict(track, now_ns, target_ns, horizon_ns)


def predict_many(track: PoseTrack, now_ns: np.ndarray, ahead_ns: int) -> np.ndarray:
    """Return (n, 4) orientations `ahead_ns` after each of `now_ns`, for statistics of a trace.

    The angular velocity is that of the WINDOW_NS before. Unlike `predict` this interpolates the
    poses at both ends of the window, so the result does not depend on where the samples lie.
    """
    q1 = track.sample_many(now_ns).orientation_xyzw
    q0 = track.sample_many(now_ns - WINDOW_NS).orientation_xyzw
    turn = quaternions.to_rotation_vector(quaternions.multiply(q1, quaternions.conjugate(q0)))
    return quaternions.multiply(quaternions.from_rotation_vector(turn * (ahead_ns / WINDOW_NS)), q1)
