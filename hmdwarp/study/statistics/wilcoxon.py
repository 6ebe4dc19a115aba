"""Wilcoxon's signed-rank test, exact however many ties there are, and the effect size that belongs to it."""

from __future__ import annotations

import functools
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

MOST_PAIRS = 1000  # the distribution takes n^3 / 2 additions: half a second for so many
_DIGITS = (
    9  # differences of decimals (4.25 - 3.15) are no exact numbers: equal to this many digits of the largest is equal
)


class Wilcoxon(NamedTuple):
    """w_plus, w_minus: sums of the midranks of positive and of negative differences. p: exact, two-sided. n: differences that are not 0."""

    w_plus: float
    w_minus: float
    p: float
    n: int


def wilcoxon_exact(differences: ArrayLike) -> Wilcoxon:
    """Whether differences lie around 0: exact two-sided p with midranks for ties, zeros dropped (Wilcoxon's own rule).

    The p is twice the share of the 2^n ways to give these ranks their signs whose larger sum is at least as large, at most 1. It is 1 where
    nothing differs from 0. differences: 1-D, finite. Errors: ValueError for others and for more than MOST_PAIRS.
    Source: Pratt and Gibbons, Concepts of Nonparametric Theory, 1981, ch. 3. SciPy's method="exact" counts as if there were no ties.
    """
    plus, minus = _doubled_sums(differences)
    p = min(1.0, 2.0 * float(_tail(plus[1], max(plus[0], minus))))
    return Wilcoxon(plus[0] / 2, minus / 2, p, len(plus[1]))


def rank_biserial(differences: ArrayLike) -> float:
    """The matched-pairs rank-biserial correlation, -1..1: (W+ - W-) / (W+ + W-); 0 where nothing differs. Source: Kerby 2014."""
    w_plus, w_minus, _, n = wilcoxon_exact(differences)
    return (w_plus - w_minus) / (w_plus + w_minus) if n else 0.0


def smallest_p(n: int) -> float:
    """The least two-sided p that n pairs can give: every one of them pointing the same way. 1 for none."""
    return min(1.0, 2.0 / 2.0**n)


def rounded(differences: ArrayLike) -> NDArray[np.float64]:
    """Differences in units of the largest, equal ones made equal. Errors: ValueError where they are not finite or not 1-D."""
    values = np.asarray(differences, dtype=np.float64)
    if values.ndim != 1 or not np.isfinite(values).all():
        raise ValueError("differences are a list of finite numbers; leave missing ones out")
    largest = np.abs(values).max(initial=0.0)
    return np.round(values / largest, _DIGITS) if largest > 0 else values


def signed_rank_null(doubled_ranks: tuple[int, ...]) -> NDArray[np.float64]:
    """P(sum of the doubled ranks with a positive sign = i), i from 0 to their sum, each sign a fair coin. (sum + 1,) float64.

    Built up rank by rank; only halves and sums of positive numbers, so that no digit is lost.
    """
    null = np.zeros(sum(doubled_ranks) + 1)
    null[0] = 1.0
    top = 0
    for rank in doubled_ranks:
        null[: top + rank + 1] *= 0.5
        null[rank : top + rank + 1] += null[: top + 1].copy()
        top += rank
    return null


def _doubled_sums(differences: ArrayLike) -> tuple[tuple[int, tuple[int, ...]], int]:
    from scipy.stats import rankdata

    values = rounded(differences)
    values = values[values != 0]
    if len(values) > MOST_PAIRS:
        raise ValueError(f"{len(values)} differences: the exact test is for {MOST_PAIRS} at most")
    ranks = np.rint(2 * rankdata(np.abs(values))).astype(int)
    plus, minus = int(ranks[values > 0].sum()), int(ranks[values < 0].sum())
    return (plus, tuple(sorted(ranks.tolist()))), minus


def _upper_tails(doubled_ranks: tuple[int, ...]) -> NDArray[np.float64]:
    return np.cumsum(signed_rank_null(doubled_ranks)[::-1])[::-1]


# A simulation of thousands of studies meets the same ranks again and again. Of many pairs few are kept: with 1000 one takes 8 MB.
_FEW = 40
_of_few, _of_many = functools.lru_cache(maxsize=4096)(_upper_tails), functools.lru_cache(maxsize=32)(_upper_tails)


def _tail(doubled_ranks: tuple[int, ...], at_least: int) -> float:
    return (_of_few if len(doubled_ranks) <= _FEW else _of_many)(doubled_ranks)[at_least]
