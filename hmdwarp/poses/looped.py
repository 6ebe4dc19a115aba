"""A recording as a head that is there now, for as long as anybody looks: forwards, then backwards, and so on."""

from __future__ import annotations

from collections.abc import Callable

import attrs

from .sample import PoseSample
from .track import PoseTrack


class LoopedSource:
    """As PoseSource, on the clock `now_ns`. From its end a track is played back to its beginning: nothing jumps there.

    restart(): from the beginning of the track, now.
    """

    def __init__(self, track: PoseTrack, now_ns: Callable[[], int]) -> None:
        self.track, self._now_ns = track, now_ns
        self._begun_ns = now_ns()

    def start(self) -> None:
        """Nothing to get ready."""

    def restart(self) -> None:
        """The track begins at this instant."""
        self._begun_ns = self._now_ns()

    def head_at(self, time_ns: int) -> PoseSample:
        """As the track has it; before its beginning, as it begins. read_ns: the clock when it was asked."""
        sample = self.track.at(self.track.start_ns + folded(time_ns - self._begun_ns, self.track.duration_ns))
        return attrs.evolve(sample, time_ns=time_ns, read_ns=self._now_ns())

    def close(self) -> None:
        """Nothing to let go of."""


def folded(since_ns: int, length_ns: int) -> int:
    """0 to length and back again, without end; 0 before the beginning."""
    if since_ns <= 0 or length_ns <= 0:
        return 0
    turn, at_ns = divmod(since_ns, length_ns)
    return length_ns - at_ns if turn % 2 else at_ns
