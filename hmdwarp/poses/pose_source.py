"""Sources of head poses, and recordings as sources: once, or forwards and backwards without end."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, runtime_checkable

import attrs

from .track import PoseSample, PoseTrack


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


class LoopedSource:
    """A PoseSource over a track, on the clock `now_ns`.

    At its end the track is played backwards to its beginning, so that nothing jumps.
    """

    def __init__(self, track: PoseTrack, now_ns: Callable[[], int]) -> None:
        self.track, self._now_ns = track, now_ns
        self._begun_ns, self._begun = now_ns(), 0

    def start(self) -> None:
        """Do nothing: a track is ready."""

    def restart(self) -> None:
        """Begin the track at this instant."""
        self._begun_ns, self._begun = self._now_ns(), self._begun + 1

    def head_at(self, time_ns: int) -> PoseSample:
        """Return the track's pose, before its beginning its first; read_ns: the clock now.

        space: how often it has begun again.
        """
        sample = self.track.at(self.track.start_ns + self.moment(time_ns).since_ns)
        return attrs.evolve(sample, time_ns=time_ns, read_ns=self._now_ns(), space=self._begun)

    def moment(self, time_ns: int) -> Moment:
        """Return where the recording is at an instant of the clock."""
        return folded(time_ns - self._begun_ns, self.track.duration_ns)

    def close(self) -> None:
        """Do nothing: a track holds no device."""


@attrs.frozen
class Moment:
    """An instant of a recording that is played, since its beginning."""

    since_ns: int
    is_backwards: bool = False


def folded(since_ns: int, length_ns: int) -> Moment:
    """Return 0 to length and back again, endlessly; 0 before the beginning."""
    if since_ns <= 0 or length_ns <= 0:
        return Moment(0)
    turn, at_ns = divmod(since_ns, length_ns)
    return Moment(length_ns - at_ns, True) if turn % 2 else Moment(at_ns)
