"""Figures of a participant's head in a trial: how far it moved, and the score of a task."""

from __future__ import annotations

import math
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

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


@attrs.define(eq=False)
class TaskScore:
    """Score of one trial. A target is selected by a confirmation while the head points at it."""

    places_m: NDArray[np.float64]  # (n, 3) of the targets, in the world
    size_deg: float  # the head's direction may be off by as much
    times_s: list[float] = attrs.field(factory=list)  # of the selections, since the first picture
    misses: int = 0
    turned_deg: float = 0.0  # path of the head until the last target was found
    _left: list[int] = attrs.field(init=False)
    _head: Pose | None = None

    def __attrs_post_init__(self) -> None:
        self._left = list(range(len(self.places_m)))

    @property
    def is_over(self) -> bool:
        """Whether all targets are found."""
        return not self._left

    def add(self, head: PoseSample) -> None:
        """Take the head of a picture; one held because tracking was lost is no motion."""
        if head.origin is Origin.HELD or self.is_over:
            return
        if self._head is not None:
            self.turned_deg += _turn_deg(self._head, head.pose)
        self._head = head.pose

    def select(self, seen_s: float) -> None:
        """Select the nearest target that the head points at, at that time; else count a miss."""
        if self.is_over or self._head is None:
            return
        off = self._off_deg(self._head)
        nearest = min(self._left, key=lambda number: off[number])
        if off[nearest] > self.size_deg:
            self.misses += 1
            return
        self._left.remove(nearest)
        self.times_s.append(seen_s)

    def _off_deg(self, head: Pose) -> NDArray[np.float64]:
        ahead = -np.array(head.rotation_matrix)[:, 2]
        ways = self.places_m - np.array(head.position_m)
        return np.asarray(np.degrees(np.arccos(np.clip(ways @ ahead / np.linalg.norm(ways, axis=1), -1, 1))))

    def figures(self, seen_s: float) -> dict[str, Any]:
        """Return the figures of study/actual.py. seen_s: since the first picture."""
        found = len(self.times_s)
        spent_s = self.times_s[-1] if self.is_over else seen_s
        return {
            "task_targets": len(self.places_m),
            "task_found": found,
            "task_misses": self.misses,
            "task_target_s": spent_s / found if found else None,
            "task_turned_deg": self.turned_deg,
            "task_times_s": " ".join(f"{time_s:.3f}" for time_s in self.times_s),
        }


def _turn_deg(one: Pose, other: Pose) -> float:
    near = abs(sum(a * b for a, b in zip(one.unit_quaternion, other.unit_quaternion, strict=True)))
    return math.degrees(2 * math.acos(min(near, 1.0)))
