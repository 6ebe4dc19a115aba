"""Where head poses come from, as the loop sees it."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from .sample import PoseSample
from .track import PoseTrack


@runtime_checkable
class PoseSource(Protocol):
    """Something that knows where the head is: a recording, a mouse, a headset."""

    def start(self) -> None:
        """Get ready; called once before the first `head_at`."""

    def head_at(self, time_ns: int) -> PoseSample:
        """world_from_head at an instant of this source's clock."""

    def close(self) -> None:
        """Let go of devices; may be called twice."""


class RecordedSource:
    """A recorded track as a source: the same instant always gives the same pose."""

    def __init__(self, track: PoseTrack) -> None:
        self.track = track

    def start(self) -> None:
        """Nothing to get ready."""

    def head_at(self, time_ns: int) -> PoseSample:
        """`PoseTrack.at`: interpolated, HELD outside the recording and within its gaps."""
        return self.track.at(time_ns)

    def close(self) -> None:
        """Nothing to let go of."""
