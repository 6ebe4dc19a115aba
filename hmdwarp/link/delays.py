"""Delay models of the network: constant, spread around the latency, or measured on a real one."""

from __future__ import annotations

import itertools
import math
from abc import ABC, abstractmethod
from collections.abc import Iterator
from pathlib import Path
from statistics import NormalDist
from typing import TYPE_CHECKING, ClassVar, Self

import attrs

from ..base import InputError, Registry
from ..base.named_files import DELAYS, text_in

if TYPE_CHECKING:
    import numpy as np  # help does not wait for it

LONGEST_MS = 60_000.0  # more is probably another unit, such as microseconds
_REACH = 6.0  # standard deviations: one frame in 1e9 lies beyond, and memory needs a bound
_MOST_LINES = 10_000_000  # 80 MB; a day of frames at 90 Hz is 7.8 million


class DelayModel(ABC):
    """Delays around a latency, reproducible by seed; an attrs.frozen class."""

    name: ClassVar[str]

    @classmethod
    @abstractmethod
    def parse(cls, argument: str) -> Self:
        """Parse what follows the name and a colon, "" for nothing. Errors: InputError."""

    def check(self, latency_ns: int) -> None:
        """Check the latency. Errors: InputError if the model cannot be applied to it."""
        if not 0 <= latency_ns < math.inf:  # NaN too
            raise InputError(f"--latency {latency_ns / 1e6:g} ms: expected 0 or more")

    @abstractmethod
    def samples(self, latency_ns: int, rng: np.random.Generator) -> Iterator[int]:
        """Yield the delay of each frame in ns, 0 or more, endlessly."""

    def longest_ns(self, latency_ns: int) -> int:
        """Return a bound on the delays."""
        return latency_ns

    def typical_ns(self, latency_ns: int) -> int:
        """Return the mean delay."""
        return latency_ns


delay_models: Registry[type[DelayModel]] = Registry("delay model", "", "delays")


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

    def samples(self, latency_ns: int, rng: np.random.Generator) -> Iterator[int]:
        return itertools.repeat(latency_ns)


@attrs.frozen
class _Jitter(DelayModel):
    spread_ms: float

    @classmethod
    def parse(cls, argument: str) -> Self:
        value = _milliseconds(argument)
        if value is None:
            raise InputError(f"--jitter {cls.name} '{argument}': expected milliseconds, from 0 to {LONGEST_MS:g}")
        return cls(value)


@delay_models.register
@attrs.frozen
class UniformJitter(_Jitter):
    """From latency - spread_ms to latency + spread_ms, all equally likely."""

    name = "uniform"

    def check(self, latency_ns: int) -> None:
        super().check(latency_ns)
        if round(self.spread_ms * 1e6) > latency_ns:
            found = f"--jitter uniform:{self.spread_ms:g} around a latency of {latency_ns / 1e6:g} ms"
            raise InputError(
                f"{found} would have frames arrive before they were sent: expected a jitter of at most the latency"
            )

    def longest_ns(self, latency_ns: int) -> int:
        return latency_ns + round(self.spread_ms * 1e6)

    def samples(self, latency_ns: int, rng: np.random.Generator) -> Iterator[int]:
        spread = round(self.spread_ms * 1e6)
        while True:
            yield latency_ns + round((2 * rng.random() - 1) * spread)


@delay_models.register
@attrs.frozen
class NormalJitter(_Jitter):
    """A normal distribution around the latency, truncated at 0 and at 6 deviations above it.

    spread_ms: its standard deviation. Truncated, not clipped, so that no probability piles up at
    the ends. For a latency of few deviations the mean is above it.
    """

    name = "normal"

    def longest_ns(self, latency_ns: int) -> int:
        return latency_ns + math.ceil(_REACH * (self.spread_ms * 1e6))

    def typical_ns(self, latency_ns: int) -> int:
        unit, deviation = NormalDist(), self.spread_ms * 1e6
        if not deviation:
            return latency_ns
        low = -min(latency_ns / deviation, _REACH)
        share = unit.cdf(_REACH) - unit.cdf(low)
        return latency_ns + round(deviation * (unit.pdf(low) - unit.pdf(_REACH)) / share)

    def samples(self, latency_ns: int, rng: np.random.Generator) -> Iterator[int]:
        unit, deviation, longest = NormalDist(), self.spread_ms * 1e6, self.longest_ns(latency_ns)
        low = unit.cdf(-min(latency_ns / deviation, _REACH)) if deviation else 0.5
        high, least = unit.cdf(_REACH), 2.0**-60  # inv_cdf accepts only values strictly between 0 and 1
        while True:
            share = max(low + (high - low) * rng.random(), least)
            yield min(max(0, latency_ns + round(deviation * unit.inv_cdf(share))), longest)


@delay_models.register
@attrs.frozen
class DelayTrace(DelayModel):
    """The delays of a file, one for each frame, repeated when they end.

    The latency is ignored.
    """

    name = "trace"
    delays_ms: tuple[float, ...] = attrs.field(repr=lambda delays: f"<{len(delays)} delays>")
    path: Path

    @classmethod
    def parse(cls, argument: str) -> DelayTrace:
        if not argument:
            raise InputError("--jitter 'trace': expected a file of delays after it (--delay-trace FILE)")
        return cls(tuple(read_delays(Path(argument))), Path(argument))

    def longest_ns(self, latency_ns: int) -> int:
        return round(max(self.delays_ms) * 1e6)

    def typical_ns(self, latency_ns: int) -> int:
        return round(math.fsum(self.delays_ms) / len(self.delays_ms) * 1e6)

    def samples(self, latency_ns: int, rng: np.random.Generator) -> Iterator[int]:
        return (round(delay * 1e6) for delay in itertools.cycle(self.delays_ms))


def read_delays(path: Path) -> list[float]:
    """Read the delays in ms of a text file with one number a line.

    # starts a comment; the first line may be a heading.
    Errors: InputError with file, line and value.
    """
    delays, may_be_heading = list[float](), True
    for number, line in enumerate(text_in(path, DELAYS).splitlines(), start=1):
        if not (found := line.partition("#")[0].strip()):
            continue
        is_word = found[0].isalpha() and found.lower() not in ("nan", "inf", "infinity")
        is_heading, may_be_heading = may_be_heading and is_word, False
        if is_heading:
            continue
        value = _milliseconds(found)
        if value is None:
            shown = found if len(found) <= 40 else found[:37] + "..."
            raise InputError(
                f"{path}: line {number}: '{shown}': expected one delay in milliseconds, from 0 to {LONGEST_MS:g}"
            )
        delays.append(value)
        if len(delays) > _MOST_LINES:
            raise InputError(f"{path}: line {number}: expected at most {_MOST_LINES} delays")
    if not delays:
        raise InputError(f"{path}: holds no delay; expected one number of milliseconds a line")
    return delays


def _milliseconds(text: str) -> float | None:
    try:
        value = float(text.encode("ascii"))
    except ValueError:
        return None
    return value if 0 <= value <= LONGEST_MS else None  # not NaN
