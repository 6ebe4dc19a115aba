"""Power of the exact tests of one comparison, computed from their distributions."""

from __future__ import annotations

import math
from statistics import NormalDist

import numpy as np

from .rank_tests import signed_rank_null

TARGET = 0.8
_NORMAL = NormalDist()  # of Python: 'study plan' begins without SciPy
JOD_SPREAD = 1 / _NORMAL.inv_cdf(0.75)  # of the difference of two judgements, so that 1 JOD gives 75 %
_CELLS = 40  # of the sizes of differences: 80 give the same power within 0.002


def signed_rank_power(people: int, effect: float, alpha: float) -> float:
    """Return the power of the two-sided exact signed-rank test of normal differences.

    effect: their mean, in standard deviations. Given its size, a difference has its sign by itself:
    from the smallest size to the largest, cell by cell, the transform of the positive ranks' sum is
    multiplied by that of each next rank. After Klotz 1963, Ann Math Stat 34, 624.
    """
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
    for plus, minus in zip(*(np.diff([*map(_NORMAL.cdf, edges + e)]) for e in (-effect, effect)), strict=True):
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
    null, true = (
        [math.comb(people, k) * p**k * (1 - p) ** (people - k) for k in range(people + 1)] for p in (0.5, share)
    )
    enough = int(np.sum(np.cumsum(null) <= alpha / 2))  # smallest counts that are significant
    return math.fsum(true[:enough] + true[people + 1 - enough :])


def people_for_signed_rank(effect: float, alpha: float) -> int:
    """Return the fewest people who find an effect by TARGET: some pi / 3 of Student's number."""
    people = int(math.pi / 3 * ((_NORMAL.inv_cdf(1 - alpha / 2) + _NORMAL.inv_cdf(TARGET)) / effect) ** 2) + 2
    while signed_rank_power(people, effect, alpha) < TARGET:
        people += 1
    while signed_rank_power(people - 1, effect, alpha) >= TARGET:
        people -= 1
    return people


def people_for_sign(share: float, alpha: float) -> int:
    """Return the fewest people from whom on more find it as well, by TARGET, of 400 at most."""
    return max(people for people in range(1, 400) if sign_power(people, share, alpha) < TARGET) + 1
