"""A compensator that changes what it runs, so that it stays within its time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import attrs

from ..client.compensator import Compensator, EyeResult, Stages
from .governor import Change, Governor

if TYPE_CHECKING:
    from ..client.inputs import PassInputs
    from ..client.plan import Plan
    from ..gpu.context import Gpu
    from .levels import QualityLevel


class AdaptiveCompensator:
    """Has a compensator for each rung of the governor's ladder and runs the governor's; stands where a Compensator stands.

    Frames carry what any of the rungs needs. All are compiled and allocated at the start, so that a change costs nothing at the
    refresh it happens. took() tells the governor what a refresh took, after both eyes: they change together. `changes` lists
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
    def ladder(self) -> tuple[QualityLevel, ...]:
        """What it chooses from, from cheapest to most accurate."""
        return self._governor.ladder

    @property
    def budget_ms(self) -> float:
        """What a refresh may take for one eye."""
        return self._governor.budget_ms

    @property
    def _running(self) -> Compensator:
        return self._compensators[self._governor.level]

    def run(self, inputs: PassInputs) -> EyeResult:
        """As Compensator.run, by the present rung, which gets what it would get alone."""
        return self._running.run(attrs.evolve(inputs, rendered=inputs.rendered.only(self.plan.needs)))

    def record_timings(self, stages: Sequence[Stages]) -> None:
        """What the passes of each eye took at the refresh that was just made; the slower eye counts."""
        change = self._governor.measured(max(sum(milliseconds for _, milliseconds in eye) for eye in stages))
        if change is not None:
            self.changes.append(change)

    def close(self) -> None:
        """Free every texture and buffer of all rungs."""
        for compensator in self._compensators.values():
            compensator.close()
