"""Several conditions or several tests: Friedman's test, Kendall's W, Holm's correction."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike


class Friedman(NamedTuple):
    """Result of Friedman's test."""

    chi2: float  # corrected for ties
    df: int
    p: float  # of the chi-squared approximation
    n: int  # participants without a missing rating


def friedman(table: ArrayLike) -> Friedman | None:
    """Test whether all conditions are rated alike.

    table: (participants, conditions), NaN for missing; participants with a missing rating are left
    out. None for fewer than three conditions or two participants. Where every participant rates all
    conditions the same, chi2 is 0 and p is 1.

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
    """Return how much participants agree on the order of the conditions, 0..1."""
    return found.chi2 / (found.n * found.df)


def holm(ps: Sequence[float]) -> list[float]:
    """Return each test's p after Holm's step-down correction, in the order of `ps`.

    statsmodels has the same, but collects garbage in each call: 30 ms, half an hour for a power
    simulation of a thousand studies that otherwise takes seconds.

    Source: Holm 1979.
    """
    order = np.argsort(ps, kind="stable")
    stepped = np.maximum.accumulate(np.array(ps)[order] * np.arange(len(ps), 0, -1))
    out = np.empty(len(ps))
    out[order] = np.minimum(stepped, 1)
    return out.tolist()
