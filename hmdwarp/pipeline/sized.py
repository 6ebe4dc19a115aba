"""A plan for frames of more than one size, as a server makes them that lowers its resolution."""

from __future__ import annotations

from collections.abc import Callable

from ..client import ClientScene
from ..client.compensator import Compensator, EyeResult
from ..client.inputs import PassInputs
from ..client.plan import Plan
from ..gpu.context import Gpu
from ..headsets import Headset

Size = tuple[int, int]


class SizedCompensator(Compensator):
    """Compensate frames of any size: passes for another than `rendered` are made when one comes.

    What a pass remembers of earlier refreshes is of one size.
    """

    def __init__(
        self, gpu: Gpu, plan: Plan, headset: Headset | None, rendered: Size, shown: Size, geometry: ClientScene
    ) -> None:
        super().__init__(gpu, plan, headset, rendered, shown, geometry)
        self._full_size = rendered
        self._others: dict[Size, Compensator] = {}
        self._make: Callable[[Size], Compensator] = lambda size: Compensator(gpu, plan, headset, size, shown, geometry)

    def run(self, inputs: PassInputs) -> EyeResult:
        """Run the plan on a frame of its size; see Compensator.run."""
        size = inputs.rendered.size
        if size == self._full_size:
            return super().run(inputs)
        if size not in self._others:
            self._others[size] = self._make(size)
        return self._others[size].run(inputs)

    def close(self) -> None:
        """Free every texture and buffer of all sizes."""
        super().close()
        for other in self._others.values():
            other.close()
