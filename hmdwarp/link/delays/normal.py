"""Normally distributed delays around the latency."""

from __future__ import annotations

import math
from collections.abc import Iterator
from statistics import NormalDist

import attrs
import numpy as np

from . import DelayModel, delay_models, milliseconds

_REACH = 6.0  # standard deviations: one frame in 1e9 lies beyond, and memory needs a bound


@delay_models.register
@attrs.frozen
class NormalJitter(DelayModel):
    """A normal distribution around the latency, truncated at 0 and at 6 deviations above it.

    Truncated, not clipped, so that no probability piles up at the ends. For a latency of few
    deviations the mean is above it.
    """

    name = "normal"
    # Standard deviation.
    deviation_ms: float

    @classmethod
    def parse(cls, argument: str) -> NormalJitter:
        return cls(milliseconds("--jitter normal", argument))

    @property
    def _deviation_ns(self) -> float:
        return self.deviation_ms * 1e6

    def longest_ns(self, latency_ns: int) -> int:
        return latency_ns + math.ceil(_REACH * self._deviation_ns)

    def typical_ns(self, latency_ns: int) -> int:
        if not self._deviation_ns:
            return latency_ns
        unit = NormalDist()
        low = -min(latency_ns / self._deviation_ns, _REACH)
        share = unit.cdf(_REACH) - unit.cdf(low)
        return latency_ns + round(self._deviation_ns * (unit.pdf(low) - unit.pdf(_REACH)) / share)

    def samples(self, latency_ns: int, rng: np.random.Generator) -> Iterator[int]:
        unit, deviation = NormalDist(), self._deviation_ns
        low = unit.cdf(-min(latency_ns / deviation, _REACH)) if deviation else 0.5
        high, least = unit.cdf(_REACH), 2.0**-60  # inv_cdf accepts only values strictly between 0 and 1
        longest = self.longest_ns(latency_ns)
        while True:
            share = max(low + (high - low) * rng.random(), least)
            yield min(max(0, latency_ns + round(deviation * unit.inv_cdf(share))), longest)
