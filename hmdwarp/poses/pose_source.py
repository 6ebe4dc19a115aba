"""Sources of head poses."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from .sample import PoseSample
from .track import PoseTrack


@runtime_checkable
class PoseSource(Protocol):
    """A source of head poses: a recording, a mouse, a headset."""

    def start(self) -> None:
        """Prepare; called once before the first `head_at`."""

    def head_at(self, time_ns: int) -> PoseSample:
        """Return world_from_head at an instant of this source's clock."""

    def close(self) -> None:
        """Release devices; safe to call twice."""


class RecordedSource:
    """A recorded track as a source: the same instant always gives the same pose."""

    def __init__(self, track: PoseTrack) -> None:
        self.track = track

    def start(self) -> None:
        """Do nothing: a recording is ready."""

    def head_at(self, time_ns: int) -> PoseSample:
        """Return `PoseTrack.at`: interpolated, HELD outside the recording and within its gaps."""
        return self.track.at(time_ns)

    def close(self) -> None:
        """Do nothing: a recording holds no device."""
