"""Predictors of the head pose from known motion."""

from __future__ import annotations

from collections.abc import Callable

import attrs
import numpy as np
from numpy.typing import NDArray

from ...base import Registry
from ..options import PREDICTORS
from ..track import Origin, PoseSample, PoseTrack, Samples


@attrs.frozen
class Predictor:
    """One way to extrapolate a head's motion."""

    name: str
    summary: str
    source: str
    # (track, now_ns, target_ns, horizon_ns): the pose at target_ns from the samples up to now_ns.
    predict: Callable[[PoseTrack, int, int, int], PoseSample]
    # (track, now_ns (n,), ahead_ns): the poses that much later, as if a sample lay at each now_ns
    # and nothing were known after it. For tracks without repeated poses.
    predict_many: Callable[[PoseTrack, NDArray[np.int64], int], Samples]
    horizon_ns: int = 0  # how far ahead of the last sample at most, by default


predictors: Registry[Predictor] = Registry("predictor", __package__, modules=PREDICTORS)


def hold(track: PoseTrack, now_ns: int, target_ns: int, horizon_ns: int) -> PoseSample:
    """Return the last sample known at `now_ns`: HELD, or MEASURED at the target itself."""
    i = max(track.index_at(now_ns), 0)
    exact = int(track.time_ns[i]) == target_ns
    return PoseSample(target_ns, track.pose(i), Origin.MEASURED if exact else Origin.HELD)
