"""What plans read of a frame: the only layers that are coded, and the only bytes that count."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

import attrs

from ..client.plan import Plan, needs_of
from ..frames import Frame, Needs
from ..frames.layers import Layer, layers

# Number of the eye, and name of the layer.
Place = tuple[int, str]


@attrs.frozen
class Reads:
    """Layers by readable name, and how much of each."""

    names: frozenset[str] = frozenset()
    needs: Needs = Needs()

    @classmethod
    def of(cls, plans: Iterable[Plan]) -> Reads:
        """Return what any of the plans reads."""
        plans = tuple(plans)
        return cls(frozenset(name for plan in plans for name in plan.layers), needs_of(plans))

    @property
    def pictures(self) -> frozenset[str]:
        """What is read that the server draws for an eye, by readable name."""
        return self.names & {layer.readable() for layer in layers if not layer.per_frame}

    def __or__(self, other: Reads) -> Reads:
        return Reads(self.names | other.names, self.needs | other.needs)

    def contents(self, frame: Frame) -> Iterator[tuple[Place, type[Layer], Any]]:
        """Yield each layer that is read, with its data; what both eyes share comes once."""
        for eye, image in frame.pictures():
            for layer, data in image.only(self.needs).contents():
                if layer.readable() in self.names and not (eye and layer.per_frame):
                    yield (eye, layer.name), layer, data
