"""Delays by a formula: constant, or spread around the latency."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from statistics import NormalDist
from typing import TYPE_CHECKING

import attrs

from ...errors import InputError
from . import DelayModel, delay_models, milliseconds

if TYPE_CHECKING:
    import numpy as np  # help does not wait for it

_REACH = 6.0  # standard deviations: one frame in 1e9 lies beyond, and memory needs a bound


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


@delay_models.register
@attrs.frozen
class UniformJitter(DelayModel):
    """From latency - spread_ms to latency + spread_ms, all equally likely."""

    name = "uniform"
    spread_ms: float

    @classmethod
    def parse(cls, argument: str) -> UniformJitter:
        return cls(milliseconds("--jitter uniform", argument))

    @property
    def _spread_ns(self) -> int:
        return round(self.spread_ms * 1e6)

    def check(self, latency_ns: int) -> None:
        super().check(latency_ns)
        if self._spread_ns > latency_ns:
            found = f"--jitter uniform:{self.spread_ms:g} around a latency of {latency_ns / 1e6:g} ms"
            raise InputError(
                f"{found} would have frames arrive before they were sent: expected a jitter of at most the latency"
            )

    def longest_ns(self, latency_ns: int) -> int:
        return latency_ns + self._spread_ns

    def typical_ns(self, latency_ns: int) -> int:
        return latency_ns

    def samples(self, latency_ns: int, rng: np.random.Generator) -> Iterator[int]:
        spread = self._spread_ns
        while True:
            yield latency_ns + round((2 * rng.random() - 1) * spread)


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
