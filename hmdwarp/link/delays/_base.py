"""What every delay model answers."""

from __future__ import annotations

import abc
import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, ClassVar, Self

from ...errors import InputError

if TYPE_CHECKING:
    import numpy as np

LONGEST_MS = 60_000.0  # a minute: beyond it something else than delay is meant, such as microseconds


class DelayModel(abc.ABC):
    """Describes the delays around a latency; the same seed gives the same ones. attrs.frozen classes with a `name` of their own."""

    name: ClassVar[str]

    @classmethod
    @abc.abstractmethod
    def parse(cls, argument: str) -> Self:
        """From what follows the name and a colon on the command line, "" for nothing. Errors: InputError."""

    def check(self, latency_ns: int) -> None:
        """Errors: InputError if there are no such delays around this latency."""
        if not 0 <= latency_ns < math.inf:  # NaN too
            raise InputError(f"latency {latency_ns / 1e6:g} ms: wanted 0 or more")

    @abc.abstractmethod
    def longest_ns(self, latency_ns: int) -> int:
        """No delay is longer."""

    @abc.abstractmethod
    def typical_ns(self, latency_ns: int) -> int:
        """The mean delay."""

    @abc.abstractmethod
    def samples(self, latency_ns: int, rng: np.random.Generator) -> Iterator[int]:
        """The delay of each frame in ns, 0 or more, without end."""


def milliseconds(what: str, text: str) -> float:
    """A number of ms from 0 to LONGEST_MS. Errors: InputError that begins with `what`."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0 <= value <= LONGEST_MS:
        raise InputError(f"{what} '{text}': wanted milliseconds, from 0 to {LONGEST_MS:g}")
    return value
