"""How large a paired difference is: the Hodges-Lehmann shift with the interval that goes with the signed-rank test."""

from __future__ import annotations

import functools
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from .wilcoxon import signed_rank_null


class Shift(NamedTuple):
    """shift: the median of all pairwise means. low, high: its interval, in the units of the differences."""

    shift: float
    low: float
    high: float


def hodges_lehmann(differences: ArrayLike, level: float = 0.95) -> Shift:
    """The median of the means of all pairs of differences (each with itself too), and its interval from the exact signed-rank distribution.

    attained_level(n, level) says how sure the interval really is: levels come in steps, and with ties it is at least that. Where n is too
    small for the level it is the widest there is. NaN for no differences. Errors: ValueError where one is not finite.
    Source: Hodges and Lehmann 1963; Hollander, Wolfe and Chicken, Nonparametric Statistical Methods, 3rd ed., 3.2 and 3.3.
    """
    values = np.asarray(differences, dtype=np.float64)
    if values.ndim != 1 or not np.isfinite(values).all():
        raise ValueError("differences are a list of finite numbers; leave missing ones out")
    if not len(values):
        return Shift(np.nan, np.nan, np.nan)
    first, second = np.triu_indices(len(values))
    walsh = np.sort((values[first] + values[second]) / 2)
    left_out, _ = _left_out(len(values), level)
    return Shift(float(np.median(walsh)), float(walsh[left_out]), float(walsh[len(walsh) - 1 - left_out]))


def attained_level(n: int, level: float = 0.95) -> float:
    """How sure the interval of n differences really is: at least `level` from six on (for 95 %), less where n cannot give that much."""
    return _left_out(n, level)[1]


@functools.cache
def _left_out(n: int, level: float) -> tuple[int, float]:
    """How many pairwise means are left out at each end, and the level that makes."""
    lower = np.cumsum(signed_rank_null(tuple(range(1, n + 1))))
    left_out = max(int(np.searchsorted(lower, (1 - level) / 2 + 1e-12, side="right")) - 1, 0)
    return left_out, max(0.0, 1.0 - 2.0 * float(lower[left_out]))
