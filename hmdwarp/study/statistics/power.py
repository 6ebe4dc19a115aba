"""Power of the exact tests of one comparison, computed from their distributions."""

from __future__ import annotations

import math

import numpy as np

from .rank_tests import signed_rank_null

TARGET = 0.8
_CELLS = 40  # of the sizes of differences: 80 give the same power within 0.002


def signed_rank_power(people: int, effect: float, alpha: float) -> float:
    """Return the power of the two-sided exact signed-rank test of normal differences.

    effect: their mean, in standard deviations. Given its size, a difference has its sign by itself:
    from the smallest size to the largest, cell by cell, the transform of the positive ranks' sum is
    multiplied by that of each next rank. After Klotz 1963, Ann Math Stat 34, 624.
    """
    from scipy.special import ndtr

    null = signed_rank_null(tuple(range(1, people + 1)))
    enough = int(np.sum(np.cumsum(null[::-1]) <= alpha / 2))  # largest sums that are significant
    if not enough:
        return 0.0
    edges = np.append(np.linspace(0, abs(effect) + 4, _CELLS), np.inf)
    ranks = np.arange(1, people + 1)[:, None]
    turns = np.exp(-2j * np.pi / len(null) * (ranks * np.arange(len(null) // 2 + 1) % len(null)))
    # Row n: of the n smallest differences, times the chance that n lie below this edge.
    below = np.zeros((people + 1, turns.shape[1]), complex)
    below[0] = 1
    for plus, minus in zip(np.diff(ndtr(edges - effect)), np.diff(ndtr(edges + effect)), strict=True):
        step, more = (minus + plus * turns) * ranks, below
        for count in range(1, people + 1):
            more = np.concatenate([np.zeros_like(below[:1]), more[:-1] * step]) / count
            below = below + more
            if (people * (plus + minus)) ** count < 1e-10 * math.factorial(count):
                break
    chances = np.fft.irfft(below[people], len(null))
    return float(np.clip(chances[:enough].sum() + chances[-enough:].sum(), 0, 1))


def sign_power(people: int, share: float, alpha: float) -> float:
    """Return the power of the two-sided exact sign test of choices of which `share` go one way."""
    from scipy.stats import binom

    least = np.arange(people + 1)[binom.sf(np.arange(people + 1) - 1, people, 0.5) <= alpha / 2].min(initial=people + 1)
    return float(binom.sf(least - 1, people, share) + binom.cdf(people - least, people, share))


def people_for_signed_rank(effect: float, alpha: float) -> int:
    """Return the fewest people who find an effect by TARGET: some pi / 3 of Student's number."""
    from scipy.special import ndtri

    people = int(math.pi / 3 * float((ndtri(1 - alpha / 2) + ndtri(TARGET)) / effect) ** 2) + 2
    while signed_rank_power(people, effect, alpha) < TARGET:
        people += 1
    while signed_rank_power(people - 1, effect, alpha) >= TARGET:
        people -= 1
    return people


def people_for_sign(share: float, alpha: float) -> int:
    """Return the fewest people from whom on more find it as well, by TARGET, of 400 at most."""
    return max(people for people in range(1, 400) if sign_power(people, share, alpha) < TARGET) + 1
