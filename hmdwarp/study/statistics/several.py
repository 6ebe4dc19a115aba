"""Several conditions, or several tests, at once: Friedman's test, Kendall's W, Holm's correction."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..extra import needed


class Friedman(NamedTuple):
    """chi2, df, p: of the chi-squared approximation, ties corrected for. n: participants without a missing rating."""

    chi2: float
    df: int
    p: float
    n: int


def friedman(table: ArrayLike) -> Friedman | None:
    """Whether any of the conditions is rated unlike the others. table: (participants, conditions), NaN for missing; only rows without one
    count.

    None for fewer than three conditions or two such rows. Where every row is one value throughout, chi2 is 0 and p is 1.
    Source: Friedman 1937, with the correction for ties (Conover 1999, 5.8), by SciPy.
    """
    from scipy.stats import friedmanchisquare

    values = np.asarray(table, dtype=np.float64)
    whole = np.round(values[np.isfinite(values).all(axis=1)], 9)
    n, k = whole.shape
    if k < 3 or n < 2:
        return None
    if (np.ptp(whole, axis=1) == 0).all():
        return Friedman(0.0, k - 1, 1.0, n)
    found = friedmanchisquare(*whole.T)
    return Friedman(float(found.statistic), k - 1, float(found.pvalue), n)


def kendalls_w(found: Friedman) -> float:
    """How much participants agree on the order of the conditions, 0..1."""
    return found.chi2 / (found.n * found.df)


def holm(ps: Sequence[float]) -> list[float]:
    """The p of each test after Holm's step-down correction over all of them, in their order. Source: Holm 1979, by statsmodels."""
    if not len(ps):
        return []
    multitest = needed("statsmodels.stats.multitest", "statsmodels")
    return [float(p) for p in multitest.multipletests(list(ps), method="holm")[1]]
