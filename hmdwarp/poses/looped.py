"""A recording as an endless live head: forwards, then backwards, and so on."""

from __future__ import annotations

from collections.abc import Callable

import attrs

from .sample import PoseSample
from .track import PoseTrack


class LoopedSource:
    """A PoseSource over a track, on the clock `now_ns`.

    At its end the track is played backwards to its beginning, so that nothing jumps.
    """

    def __init__(self, track: PoseTrack, now_ns: Callable[[], int]) -> None:
        self.track, self._now_ns = track, now_ns
        self._begun_ns = now_ns()

    def start(self) -> None:
        """Do nothing: a track is ready."""

    def restart(self) -> None:
        """Begin the track at this instant."""
        self._begun_ns = self._now_ns()

    def head_at(self, time_ns: int) -> PoseSample:
        """Return the track's pose; before its beginning, its first.

        read_ns: the clock at the call.
        """
        sample = self.track.at(self.track.start_ns + folded(time_ns - self._begun_ns, self.track.duration_ns))
        return attrs.evolve(sample, time_ns=time_ns, read_ns=self._now_ns())

    def close(self) -> None:
        """Do nothing: a track holds no device."""


def folded(since_ns: int, length_ns: int) -> int:
    """Return 0 to length and back again, endlessly; 0 before the beginning."""
    if since_ns <= 0 or length_ns <= 0:
        return 0
    turn, at_ns = divmod(since_ns, length_ns)
    return length_ns - at_ns if turn % 2 else at_ns
