"""Delays evenly spread around the latency."""

from __future__ import annotations

from collections.abc import Iterator

import attrs
import numpy as np

from ...errors import InputError
from . import DelayModel, delay_models, milliseconds


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
