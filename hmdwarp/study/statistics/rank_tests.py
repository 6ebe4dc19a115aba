"""Tests of paired ratings and their intervals.

Signed ranks, exact with any number of ties; Friedman's test; Holm's correction; Efron's BCa.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from fractions import Fraction
from statistics import NormalDist
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


MOST_PAIRS = 1000  # the distribution takes n^3 / 2 additions: half a second for so many
# Differences of decimals (4.25 - 3.15) are not exact: equal to so many digits of the largest is
# equal.
_DIGITS = 9


class Wilcoxon(NamedTuple):
    """Result of the signed-rank test."""

    w_plus: float  # sum of the midranks of positive differences
    w_minus: float  # sum of the midranks of negative differences
    p: float  # exact, two-sided
    n: int  # differences other than 0


def wilcoxon_exact(differences: ArrayLike) -> Wilcoxon:
    """Test whether differences lie around 0: exact two-sided p, midranks for ties, zeros dropped.

    p is twice the share of the 2^n sign patterns of these ranks whose larger sum is at least as
    large, at most 1. It is 1 where nothing differs from 0. differences: 1-D, finite.

    Errors: ValueError for other input and for more than MOST_PAIRS.
    Source: Pratt and Gibbons, Concepts of Nonparametric Theory, 1981, ch. 3. SciPy's method="exact"
    ignores ties.
    """
    plus, ranks, minus = _doubled_sums(differences)
    p = min(1.0, 2.0 * float(_upper_tails(ranks)[max(plus, minus)]))
    return Wilcoxon(plus / 2, minus / 2, p, len(ranks))


def rank_biserial(differences: ArrayLike) -> float:
    """Return the matched-pairs rank-biserial correlation (W+ - W-) / (W+ + W-), -1..1.

    0 where nothing differs. Source: Kerby 2014.
    """
    w_plus, w_minus, _, n = wilcoxon_exact(differences)
    return (w_plus - w_minus) / (w_plus + w_minus) if n else 0.0


def smallest_p(n: int) -> float:
    """Return the smallest two-sided p that n pairs can give: all differ in one direction."""
    return min(1.0, 2.0 / 2.0**n)


class Shift(NamedTuple):
    """Hodges-Lehmann shift and its interval, in the units of the differences."""

    shift: float
    low: float
    high: float


def hodges_lehmann(differences: ArrayLike, level: float = 0.95) -> Shift:
    """Return the median of all pairwise means and its exact signed-rank interval.

    attained_level(n, level) is the interval's actual level: levels come in steps, and ties raise
    it. Where n is too small for the level, the interval is the widest one. NaN for no differences.

    Errors: ValueError for a value that is not finite.
    Source: Hodges and Lehmann 1963; Hollander, Wolfe and Chicken, Nonparametric Statistical
    Methods, 3rd ed., 3.2 and 3.3.
    """
    values = _finite(differences)
    if not len(values):
        return Shift(np.nan, np.nan, np.nan)
    first, second = np.triu_indices(len(values))
    walsh = np.sort((values[first] + values[second]) / 2)
    left_out, _ = _left_out(len(values), level)
    return Shift(float(np.median(walsh)), float(walsh[left_out]), float(walsh[len(walsh) - 1 - left_out]))


def attained_level(n: int, level: float = 0.95) -> float:
    """Return the level of the interval of n differences.

    At least `level` from six differences on (for 95 %); less where n cannot give that much.
    """
    return _left_out(n, level)[1]


@functools.cache
def _left_out(n: int, level: float) -> tuple[int, float]:
    """Return how many pairwise means to leave out at each end, and the level that makes."""
    lower = np.cumsum(signed_rank_null(tuple(range(1, n + 1))))
    left_out = max(int(np.searchsorted(lower, (1 - level) / 2 + 1e-12, side="right")) - 1, 0)
    return left_out, max(0.0, 1.0 - 2.0 * float(lower[left_out]))


def signed_rank_null(doubled_ranks: tuple[int, ...]) -> NDArray[np.float64]:
    """Return P(sum of the doubled ranks with a positive sign = i) for i from 0 to their sum.

    Each sign is a fair coin. Built up rank by rank from halves and sums of positive numbers, so
    that no digit is lost.
    """
    null = np.zeros(sum(doubled_ranks) + 1)
    null[0] = 1.0
    top = 0
    for rank in doubled_ranks:
        null[: top + rank + 1] *= 0.5
        null[rank : top + rank + 1] += null[: top + 1].copy()
        top += rank
    return null


def _finite(differences: ArrayLike) -> NDArray[np.float64]:
    values = np.asarray(differences, dtype=np.float64)
    if values.ndim != 1 or not np.isfinite(values).all():
        raise ValueError("differences are a list of finite numbers; leave missing ones out")
    return values


def _doubled_sums(differences: ArrayLike) -> tuple[int, tuple[int, ...], int]:
    """Return twice W+, twice the sorted midranks, and twice W-."""
    from scipy.stats import rankdata

    values = _finite(differences)
    largest = np.abs(values).max(initial=0.0)
    values = np.round(values / largest, _DIGITS) if largest > 0 else values
    values = values[values != 0]
    if len(values) > MOST_PAIRS:
        raise ValueError(f"{len(values)} differences: the exact test is for {MOST_PAIRS} at most")
    ranks = np.rint(2 * rankdata(np.abs(values))).astype(int)
    return int(ranks[values > 0].sum()), tuple(sorted(ranks.tolist())), int(ranks[values < 0].sum())


@functools.lru_cache(maxsize=32)  # with 1000 pairs each takes 8 MB
def _upper_tails(doubled_ranks: tuple[int, ...]) -> NDArray[np.float64]:
    return np.cumsum(signed_rank_null(doubled_ranks)[::-1])[::-1]


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

    statsmodels has the same, but collects garbage in each call, which takes 30 ms.

    Source: Holm 1979.
    """
    order = np.argsort(ps, kind="stable")
    stepped = np.maximum.accumulate(np.array(ps)[order] * np.arange(len(ps), 0, -1))
    out = np.empty(len(ps))
    out[order] = np.minimum(stepped, 1)
    return out.tolist()


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
