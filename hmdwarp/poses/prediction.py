"""Prediction of the head pose from past motion."""

from __future__ import annotations

import operator

from ..errors import InputError
from .predictors import predictors
from .sample import PoseSample
from .track import PoseTrack


def predict(
    track: PoseTrack, now_ns: int, target_ns: int, method: str = "cautious", horizon_ns: int | None = None
) -> PoseSample:
    """Return the head pose at `target_ns` as known at `now_ns`; ignore every sample after `now_ns`.

    method: name of a predictor. horizon_ns: how far ahead of the last sample at most, by default
    the predictor's own; beyond it the pose stays constant. A target at or before the last known
    sample is looked up, not predicted.
    Errors: UnknownNameError; InputError for a negative horizon.
    """
    predictor = predictors.get(method)
    horizon_ns = predictor.horizon_ns if horizon_ns is None else horizon_ns
    if horizon_ns < 0:
        raise InputError(f"prediction horizon {horizon_ns / 1e6:g} ms: expected 0 or more")
    now_ns, target_ns = operator.index(now_ns), operator.index(target_ns)
    i = track.index_at(now_ns)
    if i >= 0 and target_ns <= int(track.time_ns[i]):
        return track.at(target_ns)
    return predictor.predict(track, now_ns, target_ns, horizon_ns)
