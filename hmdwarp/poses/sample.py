"""A head pose at an instant, and how it was obtained."""

from __future__ import annotations

import enum

import attrs

from ..geometry import Pose


class Origin(enum.IntEnum):
    """How a pose was obtained. The integers are what vectorised sampling stores."""

    MEASURED = 0
    INTERPOLATED = 1
    PREDICTED = 2
    HELD = 3


@attrs.frozen(eq=False)
class PoseSample:
    """`pose` is world_from_head at `time_ns`: the instant that was asked for, not that of the sample it came from.

    read_ns: when a live source read it from its device, on the same clock; None for a recorded one, which nobody had to hurry for.
    """

    time_ns: int
    pose: Pose
    origin: Origin
    read_ns: int | None = None
