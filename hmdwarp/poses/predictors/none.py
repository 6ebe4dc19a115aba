"""No prediction: the last known pose."""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

from ..track import PoseTrack, Samples
from . import Predictor, hold, predictors


def _hold_many(track: PoseTrack, now_ns: NDArray[np.int64], ahead_ns: int) -> Samples:
    return attrs.evolve(track.sample_many(now_ns), time_ns=now_ns + ahead_ns)


predictors.register(
    Predictor("none", "the last known pose is held", "the baseline of every predictor", hold, _hold_many)
)
