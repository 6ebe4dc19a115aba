"""Proportions from a simulation with their intervals, and the number of people to invite."""

from __future__ import annotations

import math

import attrs
import numpy as np
from scipy.special import ndtri
from scipy.stats import binom

LEVEL = 0.95


@attrs.frozen
class Proportion:
    """A proportion with Wilson's interval at LEVEL, which is accurate near 0 and 1 too.

    Source: Wilson 1927, Probable inference, J Am Stat Assoc 22; recommended by Brown, Cai and
    DasGupta 2001.
    """

    hits: int
    total: int
    low: float
    high: float

    @property
    def value(self) -> float:
        """The proportion, 0..1."""
        return self.hits / self.total

    def is_uncertain_about(self, threshold: float) -> bool:
        """Return whether the true proportion may be on either side of the threshold."""
        return self.low < threshold < self.high


def proportion_of(hits: int, total: int) -> Proportion:
    """Return the proportion.

    Errors: ValueError unless 0 <= hits <= total and total is at least 1.
    """
    if not 0 <= hits <= total or total < 1:
        raise ValueError(f"{hits} of {total} is no proportion")
    z = float(ndtri((1 + LEVEL) / 2))
    p, narrowed = hits / total, 1 + z * z / total
    middle = (p + z * z / (2 * total)) / narrowed
    half = z * math.sqrt(p * (1 - p) / total + (z / (2 * total)) ** 2) / narrowed
    # At the ends the formula gives 0 and 1 only up to rounding.
    return Proportion(hits, total, 0.0 if hits == 0 else middle - half, 1.0 if hits == total else middle + half)


def people_for(complete: int, share: float, sure: float = 0.9) -> int | None:
    """Return how many must begin so that at least `complete` finish with probability `sure`.

    share: probability that one finishes. None for more than a thousand people.
    """
    counts = np.arange(complete, 1001)
    enough = binom.sf(complete - 1, counts, share) >= sure
    return int(counts[enough.argmax()]) if enough.any() else None
