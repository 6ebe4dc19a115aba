"""Shares that a simulation finds, with what chance leaves open; and how many people to invite."""

from __future__ import annotations

import math

import attrs
import numpy as np
from scipy.special import ndtri
from scipy.stats import binom

LEVEL = 0.95


@attrs.frozen
class Share:
    """hits of total. low, high: Wilson's interval at LEVEL, which stays within 0..1 and is right near its ends.

    Source: Wilson 1927, Probable inference, J Am Stat Assoc 22; recommended by Brown, Cai and DasGupta 2001.
    """

    hits: int
    total: int
    low: float
    high: float

    @property
    def value(self) -> float:
        """0..1."""
        return self.hits / self.total

    def leaves_open(self, wanted: float) -> bool:
        """Whether the true share may be on either side of that."""
        return self.low < wanted < self.high


def share_of(hits: int, total: int) -> Share:
    """Errors: ValueError unless 0 <= hits <= total and total is at least 1."""
    if not 0 <= hits <= total or total < 1:
        raise ValueError(f"{hits} of {total} is no share")
    z = float(ndtri((1 + LEVEL) / 2))
    p, narrowed = hits / total, 1 + z * z / total
    middle = (p + z * z / (2 * total)) / narrowed
    half = z * math.sqrt(p * (1 - p) / total + (z / (2 * total)) ** 2) / narrowed
    # At the ends the formula gives exactly 0 and 1 but for the last digits.
    return Share(hits, total, 0.0 if hits == 0 else middle - half, 1.0 if hits == total else middle + half)


def people_for(complete: int, share: float, sure: float = 0.9) -> int | None:
    """How many must begin so that with probability `sure` at least that many come to the end, where each does with probability `share`.
    None where that is beyond a thousand, as nearly nobody does."""
    counts = np.arange(complete, 1001)
    enough = binom.sf(complete - 1, counts, share) >= sure
    return int(counts[enough.argmax()]) if enough.any() else None
