"""The measures of a prediction: how far it misses the head, and whether it leads or lags it."""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

from . import quaternions

Array = NDArray[np.float64]

ERROR_PERCENTILES = (50, 95, 99)
# A head that has turned or moved less than this has no direction: trackers that write three
# decimals step by 0.1 degrees.
STILL_DEG, STILL_M = 0.2, 0.002
_FAR = 95  # percentile of lead and lag


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
    return _errors(np.degrees(_turn(actual, predicted)), np.degrees(_turn(known, actual)), STILL_DEG)


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
    return np.where(at_rest, np.linalg.norm(missed + moved, axis=-1), along)


def _turn(first: Array, then: Array) -> Array:
    return quaternions.to_rotation_vector(quaternions.multiply(then, quaternions.conjugate(first)))


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
