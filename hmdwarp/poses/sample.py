"""A head pose at an instant, and how it was obtained."""

from __future__ import annotations

import enum

import attrs

from ..geometry import Pose


class Origin(enum.IntEnum):
    """How a pose was obtained; vectorised sampling stores the integers."""

    MEASURED = 0
    INTERPOLATED = 1
    PREDICTED = 2
    HELD = 3


@attrs.frozen(eq=False)
class PoseSample:
    """`pose` is world_from_head at `time_ns`, the requested instant."""

    time_ns: int
    pose: Pose
    origin: Origin
    # when a live source read it from its device, on the same clock; None for recordings
    read_ns: int | None = None
