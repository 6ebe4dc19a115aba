"""Efron's BCa bootstrap interval."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

RESAMPLES, SEED = 20_000, 0
_DIGITS = 9
_FINEST = 1000  # denominator of the finest grid of ratings: thousandths, or thirds of a hundredth
_MOST_SUMS = 1_000_000  # the exact distribution of so many sums takes 0.1 s


class Interval(NamedTuple):
    """Ends of an interval, in the units of the differences."""

    low: float
    high: float


def bca(differences: ArrayLike, seed: int = SEED, resamples: int = RESAMPLES, level: float = 0.95) -> Interval:
    """Return the bias-corrected and accelerated bootstrap interval of the mean.

    Ratings come in steps. The distribution over all resamples is then computed exactly, and seed
    and resamples play no part. Differences on no common grid are resampled at random.
    The interval does not depend on the order of the differences, and mirrors with their signs. A
    single difference, or equal ones, have no spread to resample: both ends are the mean. An empty
    list gives NaN.

    Errors: ValueError for a value that is not finite.
    Source: Efron 1987; Efron and Tibshirani, An Introduction to the Bootstrap, 1993, 14.3.
    """
    values = np.sort(np.asarray(differences, dtype=np.float64))
    if values.ndim != 1 or not np.isfinite(values).all():
        raise ValueError("differences are a list of finite numbers; leave missing ones out")
    if not len(values):
        return Interval(np.nan, np.nan)
    if is_degenerate(values):
        return Interval(float(values.mean()), float(values.mean()))
    if values.sum() < 0:  # mirrored differences must not get other resamples
        low, high = _ends(-values[::-1], seed, resamples, level)
        return Interval(-high, -low)
    return Interval(*_ends(values, seed, resamples, level))


def is_degenerate(differences: ArrayLike) -> bool:
    """Return whether there is nothing to resample: fewer than two differences, or equal ones."""
    values = np.asarray(differences, dtype=np.float64)
    return len(values) < 2 or bool(np.ptp(values) <= 10.0**-_DIGITS * np.abs(values).max())


def bca_shares(below: ArrayLike, jackknifed: NDArray[np.float64], level: float = 0.95) -> NDArray[np.float64]:
    """Return the shares (2, ...) of the bootstrap distribution at which the interval ends.

    below: (...), share of the distribution below the estimate, in 0..1 exclusive; ties count half.
    jackknifed: (n, ...), the estimate without each observation in turn.
    SciPy's bootstrap uses the same formula, but only on resamples that it draws itself.

    Source: Efron 1987, Better bootstrap confidence intervals, eq. 6.8 (acceleration by jackknife).
    """
    from scipy.special import ndtr, ndtri

    bias = ndtri(below)
    pulls = jackknifed.mean(axis=0) - jackknifed
    spread = (pulls**2).sum(axis=0) ** 1.5
    acceleration = np.divide((pulls**3).sum(axis=0), 6 * spread, out=np.zeros_like(spread), where=spread > 0)
    tails = [bias + ndtri(tail) for tail in ((1 - level) / 2, (1 + level) / 2)]
    return np.asarray(ndtr([bias + tail / (1 - acceleration * tail) for tail in tails]))


def _ends(values: NDArray[np.float64], seed: int, resamples: int, level: float) -> tuple[float, float]:
    left_out = (values.sum() - values) / (len(values) - 1)
    found = _all_resamples(values)
    if found is not None:
        means, chances, below = found
        places = np.searchsorted(np.cumsum(chances), bca_shares(below, left_out, level))
        low, high = means[np.minimum(places, len(means) - 1)]
    else:
        draws = np.random.default_rng(seed).integers(0, len(values), size=(resamples, len(values)))
        means, mean = values[draws].mean(axis=1), values.mean()
        # Sums in another order differ in the last digit; a resample equal to the sample is a tie.
        near = 10.0**-_DIGITS * np.abs(values).max()
        below = ((means < mean - near).mean() + (means <= mean + near).mean()) / 2
        below = np.clip(below, 0.5 / resamples, 1 - 0.5 / resamples)
        low, high = np.quantile(means, bca_shares(below, left_out, level))
    return float(f"{low:.12g}"), float(f"{high:.12g}")  # 2.025, not what is left of it after ten additions


def _all_resamples(
    values: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64], float] | None:
    """Return every mean of a resample, its chance, and the chance of less than the mean itself.

    A resample of n is n throws of one die, so its sum has the n-fold convolution of the die. None
    where the values lie on no common grid.
    """
    n, largest = len(values), np.abs(values).max()
    parts = [Fraction(float(value)).limit_denominator(_FINEST) for value in values]
    if any(abs(float(part) - value) > 10.0**-_DIGITS * largest for part, value in zip(parts, values, strict=True)):
        return None
    if (grid := math.lcm(*(part.denominator for part in parts))) > _MOST_SUMS:
        return None
    units = np.array([part.numerator * (grid // part.denominator) for part in parts])
    units -= (least := units.min())
    units //= (step := np.gcd.reduce(units))
    size = n * int(units.max()) + 1
    if size > _MOST_SUMS:
        return None
    chances = np.fft.irfft(np.fft.rfft(np.bincount(units) / n, n=size + 1) ** n, n=size + 1)[:size].clip(0)
    means = (np.arange(size) * step / n + least) / grid
    middle = units.sum()
    return means, chances, float(chances[:middle].sum() + chances[middle] / 2)
