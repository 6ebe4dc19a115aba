"""A constant delay."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import TYPE_CHECKING

import attrs

from ...errors import InputError
from . import DelayModel, delay_models

if TYPE_CHECKING:
    import numpy as np  # help does not wait for it


@delay_models.register
@attrs.frozen
class ConstantDelay(DelayModel):
    """The latency alone."""

    name = "constant"

    @classmethod
    def parse(cls, argument: str) -> ConstantDelay:
        if argument:
            raise InputError(
                f"--jitter 'constant:{argument}': a constant delay takes no number; its length is the latency"
            )
        return cls()

    def longest_ns(self, latency_ns: int) -> int:
        return latency_ns

    def typical_ns(self, latency_ns: int) -> int:
        return latency_ns

    def samples(self, latency_ns: int, rng: np.random.Generator) -> Iterator[int]:
        return itertools.repeat(latency_ns)
