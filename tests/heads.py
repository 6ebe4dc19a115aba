"""Heads and eyes of tests that need neither a trace nor a headset."""

from __future__ import annotations

from collections.abc import Callable

from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.poses import Origin, PoseSample


class Head:
    """A source of poses that follows a function of time in ns."""

    def __init__(self, pose_at: Callable[[int], Pose]) -> None:
        self._pose_at = pose_at

    def start(self) -> None:
        """Nothing is to be started."""

    def head_at(self, time_ns: int) -> PoseSample:
        """Return the pose then."""
        return PoseSample(time_ns, self._pose_at(time_ns), Origin.MEASURED)

    def close(self) -> None:
        """Nothing is to be closed."""


class Eyes:
    """Eyes at places in the head, each with a field of view."""

    def __init__(self, *eyes: tuple[Pose, Fov]) -> None:
        self._eyes = eyes

    def views(self, world_from_head: Pose) -> tuple[View, ...]:
        """Return a view for each."""
        return tuple(View(world_from_head @ eye, fov, eye) for eye, fov in self._eyes)
