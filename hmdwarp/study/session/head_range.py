"""How far a participant's head moved in a trial: a picture that hardly moves shows no lateness."""

from __future__ import annotations

import math

import attrs

from ...geometry import Pose
from ...poses import Origin, PoseSample

# Below both, a trial counts as one in which the head hardly moved. A head that is held still sways
# by some 2 degrees and 2 cm; one that looks around turns by tens of degrees within seconds. A warp
# has next to nothing to correct below these, whatever the latency.
STILL_DEG, STILL_M = 5.0, 0.05


@attrs.define
class HeadRange:
    """Largest distances of a head from where it was first."""

    turn_deg: float = 0.0
    shift_m: float = 0.0
    _first: Pose | None = None

    def add(self, head: PoseSample) -> None:
        """Take a head; one held because tracking was lost is no motion."""
        if head.origin is Origin.HELD:
            return
        pose = head.pose
        if self._first is None:
            self._first = pose
            return
        near = abs(sum(a * b for a, b in zip(pose.unit_quaternion, self._first.unit_quaternion, strict=True)))
        self.turn_deg = max(self.turn_deg, math.degrees(2 * math.acos(min(near, 1.0))))
        self.shift_m = max(self.shift_m, math.dist(pose.position_m, self._first.position_m))

    @property
    def is_still(self) -> bool:
        """Whether the head hardly moved."""
        return self.turn_deg < STILL_DEG and self.shift_m < STILL_M

    def figures(self) -> dict[str, float | bool | None]:
        """Return the figures of study/actual.py; None throughout where no head was seen."""
        if self._first is None:
            return {"head_turn_deg": None, "head_shift_m": None, "head_still": None}
        return {"head_turn_deg": self.turn_deg, "head_shift_m": self.shift_m, "head_still": self.is_still}
