"""A compensator that switches between quality levels to stay within its time budget."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ...client.compensator import Compensator, EyeResult, Stages
from ...client.inputs import PassInputs
from ...client.plan import Plan
from ...gpu.context import Gpu
from .governor import Change, Governor
from .levels import QualityLevel


class AdaptiveCompensator:
    """One compensator for each quality level; the governor chooses which one runs.

    Drop-in for a Compensator.

    Frames carry what any of the levels needs. All levels are compiled and allocated at the start,
    so that a switch costs nothing at the refresh where it happens. Both eyes switch together.
    `changes` lists the switches.
    """

    def __init__(self, governor: Governor, compensators: Mapping[QualityLevel, Compensator]) -> None:
        self._governor, self._compensators = governor, dict(compensators)
        self.changes: list[Change] = []
        self._first_ms = governor.level.total_ms

    @property
    def gpu(self) -> Gpu:
        return self._running.gpu

    @property
    def plan(self) -> Plan:
        """The plan of the next refresh."""
        return self._running.plan

    @property
    def levels(self) -> tuple[QualityLevel, ...]:
        """All levels, from cheapest to most accurate."""
        return self._governor.levels

    @property
    def budget_ms(self) -> float:
        """Time budget of one eye at a refresh."""
        return self._governor.budget_ms

    @property
    def share_of_first(self) -> float:
        """How long the current level is expected to take, of the time of the first one."""
        return self._governor.level.total_ms / self._first_ms

    @property
    def _running(self) -> Compensator:
        return self._compensators[self._governor.level]

    def run(self, inputs: PassInputs) -> EyeResult:
        """Run the current level; see Compensator.run."""
        return self._running.run(inputs)

    def record_timings(self, stages: Sequence[Stages]) -> None:
        """Pass the stage times of the last refresh to the governor; the slower eye counts."""
        change = self._governor.measured(max(sum(milliseconds for _, milliseconds in eye) for eye in stages))
        if change is not None:
            self.changes.append(change)

    def close(self) -> None:
        """Free every texture and buffer of all levels."""
        for compensator in self._compensators.values():
            compensator.close()
