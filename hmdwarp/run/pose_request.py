"""The head pose that the server draws for: the current one, or a prediction from known motion."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable

import numpy as np

from ..frames import Needs
from ..frames.layers import PICTURE
from ..link import CHANGES
from ..pipeline.options import PipelineOptions
from ..pipeline.requested import PoseRequest
from ..poses import PoseSample, PoseSource, PoseTrack, jumps_between
from ..poses.prediction import predict

KEPT_NS = 1_000_000_000


def pose_request(
    options: PipelineOptions,
    source: PoseSource,
    known: Callable[[int], PoseTrack],
    age_ns: int,
    size: tuple[int, int],
    needs: Needs,
    *,
    pictures: frozenset[str] = frozenset(PICTURE),
) -> PoseRequest:
    """Return the poses and picture format for the server.

    known(now_ns): head motion up to that instant, and maybe later. age_ns: from drawing a frame to
    showing it. size: (w, h) of one eye. pictures: as of PoseRequest.
    """

    def predicted(now_ns: int, ahead_ns: int) -> PoseSample:
        return predict(known(now_ns), now_ns, now_ns + ahead_ns, options.predict, options.horizon_ns)

    predicts = predicted if options.predict != "none" else None
    # What has moved since a frame was sent is known from its picture.
    pictures |= frozenset(PICTURE if options.network.send == CHANGES else ())
    scanout_ns = round(options.scanout_ms * 1e6)
    return PoseRequest(source, predicts, size, options.guard_band, needs, scanout_ns, age_ns, pictures)


class RecentPoses:
    """A pose source that keeps the last second of its answers.

    A recentre, a snap turn or a teleport is a jump of the track, as in a recording.
    """

    def __init__(self, source: PoseSource) -> None:
        self._source = source
        self._kept: list[PoseSample] = []

    def start(self) -> None:
        """Start the source."""
        self._source.start()

    def head_at(self, time_ns: int) -> PoseSample:
        """Return the source's pose, and keep it."""
        sample = self._source.head_at(time_ns)
        kept = self._kept
        # What was foretold before a jump, for the display, is of where the head is no more.
        while kept and kept[-1].time_ns >= sample.time_ns and jumps_between([sample, kept[-1]]):
            kept.pop()
        at = bisect_left(kept, sample.time_ns, key=lambda pose: pose.time_ns)
        # Within known motion nothing is added; between the sides of a jump it says which is now.
        if at == len(kept) or (at and kept[at].time_ns > sample.time_ns and jumps_between([kept[at - 1], kept[at]])):
            kept.insert(at, sample)
            del kept[: bisect_left(kept, sample.time_ns - KEPT_NS, key=lambda pose: pose.time_ns)]
        return sample

    def track_until(self, now_ns: int) -> PoseTrack:
        """Return the last second of motion, including the current pose."""
        self.head_at(now_ns)
        kept = self._kept
        return PoseTrack(
            time_ns=np.array([pose.time_ns for pose in kept]),
            position_m=np.array([pose.pose.position_m for pose in kept]),
            orientation_xyzw=np.array([pose.pose.orientation_xyzw for pose in kept]),
            jumps=jumps_between(kept),
        )

    def close(self) -> None:
        """Close the source."""
        self._source.close()
