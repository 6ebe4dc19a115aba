"""Prediction of the head from past motion; how far it misses, and whether it leads or lags."""

from __future__ import annotations

import operator

import attrs
import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from . import quaternions
from .predictors import predictors
from .track import PoseSample, PoseTrack

Array = NDArray[np.float64]

ERROR_PERCENTILES = (50, 95, 99)
# A head that has turned or moved less than this has no direction: trackers that write three
# decimals step by 0.1 degrees.
STILL_DEG, STILL_M = 0.2, 0.002
_FAR = 95  # percentile of lead and lag


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


@attrs.frozen
class PredictionErrors:
    """Of many predictions: angles in degrees, or lengths in metres. NaN for no prediction at all.

    One that leads overshoots where the head stops. `signed_lead` says what leads.
    """

    mean: float
    percentiles: tuple[float, ...]  # at ERROR_PERCENTILES
    lead_share: float  # of the predictions that lead by more than STILL_DEG or STILL_M
    lead: float  # 95th percentile of the lead; 0 where it lags
    lag: float  # 95th percentile of the lag; 0 where it leads


def turn_errors(known: Array, actual: Array, predicted: Array) -> PredictionErrors:
    """Return the angles between heads and where they were predicted, in degrees.

    Orientations (n, 4): known when predicting, the actual ones that were to be predicted, and the
    predicted ones.
    """
    turn = quaternions.vector_between
    return _errors(np.degrees(turn(actual, predicted)), np.degrees(turn(known, actual)), STILL_DEG)


def move_errors(known: Array, actual: Array, predicted: Array) -> PredictionErrors:
    """Return the same of positions (n, 3), in metres."""
    return _errors(predicted - actual, actual - known, STILL_M)


def signed_lead(missed: Array, moved: Array, still: float) -> Array:
    """Return how far each prediction leads the head, (n,); negative where it lags behind.

    That is the part of the error along the head's own motion: missed (n, 3) is the rotation vector
    or way from the actual head to the predicted one, moved (n, 3) that from the known head to the
    actual one, both in the world. A head that has moved less than `still` goes nowhere: whatever
    its prediction moves is lead. Holding the known head never leads.
    """
    length = np.linalg.norm(moved, axis=-1)
    at_rest = length < still
    along = np.einsum("ij,ij->i", missed, moved) / np.where(at_rest, 1.0, length)
    # From rest to rest: what is left of the error once the head's own jitter is taken off.
    return np.asarray(np.where(at_rest, np.linalg.norm(missed + moved, axis=-1), along))


def _errors(missed: Array, moved: Array, still: float) -> PredictionErrors:
    nothing = float("nan")
    if not len(missed):
        return PredictionErrors(nothing, (nothing,) * len(ERROR_PERCENTILES), nothing, nothing, nothing)
    lengths, lead = np.linalg.norm(missed, axis=-1), signed_lead(missed, moved, still)
    return PredictionErrors(
        mean=float(lengths.mean()),
        percentiles=tuple(float(value) for value in np.percentile(lengths, ERROR_PERCENTILES)),
        lead_share=float(np.mean(lead > still)),
        lead=max(0.0, float(np.percentile(lead, _FAR))),
        lag=max(0.0, float(np.percentile(-lead, _FAR))),
    )
