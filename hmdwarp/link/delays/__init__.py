"""Delay models of the network."""

from __future__ import annotations

import abc
import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, ClassVar, Self

from ...errors import InputError
from ...registry import Registry

if TYPE_CHECKING:
    import numpy as np  # help does not wait for it

LONGEST_MS = 60_000.0  # more is probably another unit, such as microseconds


class DelayModel(abc.ABC):
    """Delays around a latency; reproducible by seed.

    Models are attrs.frozen classes.
    """

    name: ClassVar[str]

    @classmethod
    @abc.abstractmethod
    def parse(cls, argument: str) -> Self:
        """Parse the text after the name and a colon on the command line, "" for nothing.

        Errors: InputError.
        """

    def check(self, latency_ns: int) -> None:
        """Check the latency. Errors: InputError if the model cannot be applied to it."""
        if not 0 <= latency_ns < math.inf:  # NaN too
            raise InputError(f"--latency {latency_ns / 1e6:g} ms: expected 0 or more")

    @abc.abstractmethod
    def longest_ns(self, latency_ns: int) -> int:
        """Return a bound on the delays."""

    @abc.abstractmethod
    def typical_ns(self, latency_ns: int) -> int:
        """Return the mean delay."""

    @abc.abstractmethod
    def samples(self, latency_ns: int, rng: np.random.Generator) -> Iterator[int]:
        """Yield the delay of each frame in ns, 0 or more, endlessly."""


def milliseconds(what: str, text: str) -> float:
    """Parse a number of ms from 0 to LONGEST_MS.

    Errors: InputError whose message starts with `what`.
    """
    try:
        value = float(text.encode("ascii"))
    except ValueError:
        value = math.nan
    if not 0 <= value <= LONGEST_MS:
        raise InputError(f"{what} '{text}': expected milliseconds, from 0 to {LONGEST_MS:g}")
    return value


delay_models: Registry[type[DelayModel]] = Registry(
    "delay model", __name__, modules=dict.fromkeys(("constant", "normal", "uniform"), "models")
)

__all__ = ["delay_models", "LONGEST_MS", "DelayModel", "milliseconds"]
