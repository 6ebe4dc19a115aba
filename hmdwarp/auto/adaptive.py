"""A compensator that changes what it runs, so that it stays within its time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from ..client.compensator import Compensator, EyeResult, Stages
from .governor import Change, Governor

if TYPE_CHECKING:
    from ..client.inputs import PassInputs
    from ..client.plan import Plan
    from ..gpu.context import Gpu
    from .levels import QualityLevel


class AdaptiveCompensator:
    """A compensator for each quality level, of which the governor's runs.

    Stands where a Compensator stands.

    Frames carry what any of the levels needs. All are compiled and allocated at the start, so that
    a change costs nothing at the refresh it happens. Both eyes change together. `changes` lists
    what happened.
    """

    def __init__(self, governor: Governor, compensators: Mapping[QualityLevel, Compensator]) -> None:
        self._governor, self._compensators = governor, dict(compensators)
        self.changes: list[Change] = []

    @property
    def gpu(self) -> Gpu:
        return self._running.gpu

    @property
    def plan(self) -> Plan:
        """What runs at the next refresh."""
        return self._running.plan

    @property
    def levels(self) -> tuple[QualityLevel, ...]:
        """What it chooses from, from cheapest to most accurate."""
        return self._governor.levels

    @property
    def budget_ms(self) -> float:
        """Time of a refresh for one eye."""
        return self._governor.budget_ms

    @property
    def _running(self) -> Compensator:
        return self._compensators[self._governor.level]

    def run(self, inputs: PassInputs) -> EyeResult:
        """Run the present level; see Compensator.run."""
        return self._running.run(inputs)

    def record_timings(self, stages: Sequence[Stages]) -> None:
        """Hand the times of each eye's passes at the last refresh to the governor.

        The slower eye counts.
        """
        change = self._governor.measured(max(sum(milliseconds for _, milliseconds in eye) for eye in stages))
        if change is not None:
            self.changes.append(change)

    def close(self) -> None:
        """Free every texture and buffer of all levels."""
        for compensator in self._compensators.values():
            compensator.close()
