"""The head's last second: what a prediction may look at."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

import numpy as np

from ...poses import PoseSample, PoseSource, PoseTrack
from ...poses.prediction import predict

KEPT_NS = 1_000_000_000


class Recent:
    """A pose source that remembers what it was asked for."""

    def __init__(self, source: PoseSource) -> None:
        self._source = source
        self._kept: deque[PoseSample] = deque()

    def start(self) -> None:
        """As PoseSource.start."""
        self._source.start()

    def head_at(self, time_ns: int) -> PoseSample:
        """As PoseSource.head_at."""
        sample = self._source.head_at(time_ns)
        if not self._kept or sample.time_ns > self._kept[-1].time_ns:
            self._kept.append(sample)
            while sample.time_ns - self._kept[0].time_ns > KEPT_NS:
                self._kept.popleft()
        return sample

    def predictor(self, method: str, age_ns: int, horizon_ms: float) -> Callable[[int], PoseSample] | None:
        """The head when a frame drawn now will be seen, `age_ns` later, from what is known now; None for no prediction."""
        if method == "none":
            return None

        def predicted(now_ns: int) -> PoseSample:
            self.head_at(now_ns)
            return predict(self._track(), now_ns, now_ns + age_ns, method, round(horizon_ms * 1e6))

        return predicted

    def _track(self) -> PoseTrack:
        kept = list(self._kept)
        return PoseTrack(
            time_ns=np.array([one.time_ns for one in kept]),
            position_m=np.array([one.pose.position_m for one in kept]),
            orientation_xyzw=np.array([one.pose.orientation_xyzw for one in kept]),
        )

    def close(self) -> None:
        """As PoseSource.close."""
        self._source.close()
