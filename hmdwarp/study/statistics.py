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

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
RESAMPLES, SEED = 20_000, 0
_DIGITS = 9  # differences of decimals (4.25 - 3.15) are not exact: equal to so many is equal
_FINEST = 1000  # denominator of the finest grid of ratings: thousandths, or thirds of a hundredth
_MOST_SUMS = 1_000_000  # the exact distribution of so many sums takes 0.1 s


class Interval(NamedTuple):
    """Ends of an interval, in the units of the differences."""

    low: float
    high: float


def bca(differences: ArrayLike, seed: int = SEED, resamples: int = RESAMPLES, level: float = 0.95) -> Interval:
    """Return the bias-corrected and accelerated bootstrap interval of the mean.

    Ratings come in steps: over all resamples exactly, and seed and resamples play no part. Values
    on no common grid are resampled at random. Their order plays no part, and it mirrors with their
    signs. For a single difference, or equal ones, both ends are the mean; NaN for an empty list.
    Errors: ValueError for a value that is not finite.
    Source: Efron 1987; Efron and Tibshirani, An Introduction to the Bootstrap, 1993, 14.3.
    """
    values = np.sort(_finite(differences))
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


def bca_shares(below: ArrayLike, jackknifed: Array, level: float = 0.95) -> Array:
    """Return the shares (2, ...) of the bootstrap distribution at which the interval ends.

    below: (...), share below the estimate, 0..1 exclusive; ties count half. jackknifed: (n, ...).
    Source: Efron 1987, Better bootstrap confidence intervals, eq. 6.8 (acceleration by jackknife).
    """
    from scipy.special import ndtr, ndtri

    bias = ndtri(below)
    pulls = jackknifed.mean(axis=0) - jackknifed
    spread = (pulls**2).sum(axis=0) ** 1.5
    acceleration = np.divide((pulls**3).sum(axis=0), 6 * spread, out=np.zeros_like(spread), where=spread > 0)
    tails = [bias + ndtri(tail) for tail in ((1 - level) / 2, (1 + level) / 2)]
    return np.asarray(ndtr([bias + tail / (1 - acceleration * tail) for tail in tails]))


def _ends(values: Array, seed: int, resamples: int, level: float) -> tuple[float, float]:
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


def _all_resamples(values: Array) -> tuple[Array, Array, float] | None:
    """Return all means of a resample, their chances, and that of less than the mean itself."""
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


class Wilcoxon(NamedTuple):
    """Result of the signed-rank test."""

    w_plus: float  # sum of the midranks of positive differences
    w_minus: float  # sum of the midranks of negative differences
    p: float  # exact, two-sided
    n: int  # differences other than 0


def wilcoxon_exact(differences: ArrayLike) -> Wilcoxon:
    """Test whether differences lie around 0: exact two-sided p, midranks for ties, zeros dropped.

    p is twice the share of the 2^n sign patterns of these ranks whose larger sum is at least as
    large, at most 1. Errors: ValueError for more than MOST_PAIRS or infinite ones.
    Source: Pratt and Gibbons, Concepts of Nonparametric Theory, 1981, ch. 3. SciPy's method="exact"
    ignores ties.
    """
    from scipy.stats import rankdata

    values = _finite(differences)
    largest = np.abs(values).max(initial=0.0)
    values = np.round(values / largest, _DIGITS) if largest > 0 else values
    values = values[values != 0]
    if len(values) > MOST_PAIRS:
        raise ValueError(f"{len(values)} differences: the exact test is for {MOST_PAIRS} at most")
    doubled = np.rint(2 * rankdata(np.abs(values))).astype(int)
    plus, minus = (int(doubled[way].sum()) for way in (values > 0, values < 0))
    p = min(1.0, 2.0 * float(_upper_tails(tuple(sorted(doubled.tolist())))[max(plus, minus)]))
    return Wilcoxon(plus / 2, minus / 2, p, len(doubled))


def rank_biserial(differences: ArrayLike) -> float:
    """Return the matched-pairs rank-biserial correlation, -1..1, or 0 (Kerby 2014)."""
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

    Its actual level is attained_level(n, level); where n is too small, it is the widest one. NaN
    for no differences. Errors: ValueError for a value that is not finite.
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
    """Return the level of the interval of n differences: `level` at least from six on."""
    return _left_out(n, level)[1]


@functools.cache
def _left_out(n: int, level: float) -> tuple[int, float]:
    """Return how many pairwise means to leave out at each end, and the level that makes."""
    lower = np.cumsum(signed_rank_null(tuple(range(1, n + 1))))
    left_out = max(int(np.searchsorted(lower, (1 - level) / 2 + 1e-12, side="right")) - 1, 0)
    return left_out, max(0.0, 1.0 - 2.0 * float(lower[left_out]))


def signed_rank_null(doubled_ranks: tuple[int, ...]) -> Array:
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


def _finite(differences: ArrayLike) -> Array:
    values = np.asarray(differences, dtype=np.float64)
    if values.ndim != 1 or not np.isfinite(values).all():
        raise ValueError("differences are a list of finite numbers; leave missing ones out")
    return values


@functools.lru_cache(maxsize=32)  # with 1000 pairs each takes 8 MB
def _upper_tails(doubled_ranks: tuple[int, ...]) -> Array:
    return np.cumsum(signed_rank_null(doubled_ranks)[::-1])[::-1]


class Friedman(NamedTuple):
    """Result of Friedman's test."""

    chi2: float  # corrected for ties
    df: int
    p: float  # of the chi-squared approximation
    n: int  # participants without a missing rating


def friedman(table: ArrayLike) -> Friedman | None:
    """Test whether all conditions are rated alike.

    table: (participants, conditions); who misses a rating is left out. None for fewer than three
    conditions or two participants; p is 1 where everybody rates all alike.
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
    """Return each test's p after Holm's step-down correction (1979), in the order of `ps`.

    statsmodels has the same, but collects garbage in each call, which takes 30 ms.
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


@functools.cache
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
        step, more = (minus + plus * turns) * ranks, below.copy()
        for count in range(1, people + 1):
            more[count:] = more[count - 1 : -1] * step[count - 1 :] / count
            below[count:] += more[count:]
            if (people * (plus + minus)) ** count < 1e-10 * math.factorial(count):
                break
    chances = np.fft.irfft(below[people], len(null))
    return float(np.clip(chances[:enough].sum() + chances[-enough:].sum(), 0, 1))


def sign_power(people: int, share: float, alpha: float) -> float:
    """Return the power of the two-sided exact sign test of choices of which `share` go one way."""
    ways = [math.comb(people, k) for k in range(people + 1)]
    null, true = ([n * p**k * (1 - p) ** (people - k) for k, n in enumerate(ways)] for p in (0.5, share))
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


@functools.cache
def people_for_sign(share: float, alpha: float) -> int:
    """Return the fewest people from whom on more find it as well, by TARGET, of 400 at most."""
    return max(people for people in range(1, 400) if sign_power(people, share, alpha) < TARGET) + 1


PRIOR_SD = 5.0  # of a score and of the threshold, JOD: a difference of 5 JOD is one that 99.96 % see
_HALF_TIE = 0.5  # added to the ties, so that a resample without one still has a threshold
_PRIOR = (PRIOR_SD / JOD_SPREAD) ** 2
_STEPS, _CLOSE = 100, 1e-9


@attrs.frozen(eq=False)
class Scores:
    """Scores of n conditions; their mean is 0."""

    jod: Array  # (.., n)
    threshold: Array  # (..) below which a difference is called none, JOD; 0 without ties


def jod_scores(wins: Array, ties: Array | None = None) -> Scores:
    """Scale comparisons. wins: (.., n, n), how often the row was preferred to the column.

    ties: (.., n, n), symmetric; None where "no difference" could not be answered.
    """
    shape, n = np.shape(wins)[:-2], np.shape(wins)[-1]
    first, second = np.triu_indices(n, 1)
    tables = np.asarray(wins, np.float64).reshape(-1, n, n)
    won, lost = tables[:, first, second], tables[:, second, first]
    tied = np.zeros_like(won) if ties is None else np.asarray(ties, np.float64).reshape(-1, n, n)[:, first, second]
    of = _Likelihood(won, lost, tied, np.eye(n)[first] - np.eye(n)[second], has_ties=ties is not None)
    at = of.highest()
    threshold = at[:, n] if ties is not None else np.zeros(len(at))
    return Scores(at[:, :n].reshape(*shape, n) * JOD_SPREAD, threshold.reshape(shape) * JOD_SPREAD)


@attrs.frozen(eq=False)
class _Likelihood:
    """Log of the posterior density of tables at once; scores in units of JOD_SPREAD."""

    won: Array  # (batch, pairs)
    lost: Array
    tied: Array
    pairs: Array  # (pairs, n): 1 and -1
    has_ties: bool

    def value(self, at: Array) -> Array:
        """Return it (batch); -inf for a threshold that is not positive."""
        from scipy.special import log_ndtr

        d, t = self._differences(at)
        found = (self.won * log_ndtr(d - t) + self.lost * log_ndtr(-d - t)).sum(axis=1)
        if self.has_ties:
            with np.errstate(divide="ignore", invalid="ignore"):
                found += (self.tied * np.log(_between(d, t))).sum(axis=1) + _HALF_TIE * np.log(at[:, -1])
            found = np.where(at[:, -1] > 0, found, -np.inf)
        return np.asarray(found - (at**2).sum(axis=1) / (2 * _PRIOR))

    def highest(self) -> Array:
        """Climb to the one maximum by Newton's steps, halved where they overshoot."""
        at = np.zeros((len(self.won), self.pairs.shape[1] + self.has_ties))
        at[:, self.pairs.shape[1] :] = 0.3
        value = self.value(at)
        for _ in range(_STEPS):
            gradient, hessian = self.derivatives(at)
            step = np.linalg.solve(-hessian, gradient[..., None])[..., 0]
            if np.abs(step).max(initial=0.0) < _CLOSE:
                break
            scale = np.ones(len(at))
            while True:
                tried = self.value(at + scale[:, None] * step)
                low = (tried < value - 1e-9 * np.abs(value)) & (scale > 1e-6)
                if not low.any():
                    break
                scale[low] /= 2
            at, value = at + scale[:, None] * step, tried
        return at

    def derivatives(self, at: Array) -> tuple[Array, Array]:
        """Return gradient (batch, m) and Hessian (batch, m, m)."""
        d, t = self._differences(at)
        (win, win2), (loss, loss2) = _slopes(d - t), _slopes(-d - t)
        by_d, by_dd = self.won * win - self.lost * loss, self.won * win2 + self.lost * loss2
        by_t, by_dt = -self.won * win - self.lost * loss, -self.won * win2 + self.lost * loss2
        by_tt = by_dd.copy()
        if self.has_ties:
            u, v = d + t, d - t
            p, pu, pv = _between(d, t), _density(u), _density(v)
            gd, gt = (pu - pv) / p, (pu + pv) / p
            same, other = (-u * pu + v * pv) / p, (-u * pu - v * pv) / p
            by_d, by_t = by_d + self.tied * gd, by_t + self.tied * gt
            by_dd, by_tt = by_dd + self.tied * (same - gd**2), by_tt + self.tied * (same - gt**2)
            by_dt = by_dt + self.tied * (other - gd * gt)
        n = self.pairs.shape[1]
        gradient, hessian = -at / _PRIOR, np.zeros((*at.shape, at.shape[1]))
        gradient[:, :n] += by_d @ self.pairs
        hessian[:, :n, :n] = np.einsum("bp,pi,pj->bij", by_dd, self.pairs, self.pairs, optimize=True)
        if self.has_ties:
            gradient[:, n] += by_t.sum(axis=1) + _HALF_TIE / at[:, n]
            hessian[:, n, n] = by_tt.sum(axis=1) - _HALF_TIE / at[:, n] ** 2
            hessian[:, :n, n] = hessian[:, n, :n] = by_dt @ self.pairs
        hessian[:, range(at.shape[1]), range(at.shape[1])] -= 1 / _PRIOR
        return gradient, hessian

    def _differences(self, at: Array) -> tuple[Array, Array]:
        n = self.pairs.shape[1]
        return at[:, :n] @ self.pairs.T, at[:, -1:] if self.has_ties else np.zeros((len(at), 1))


def _density(x: Array) -> Array:
    return np.asarray(np.exp(-(x**2) / 2) / np.sqrt(2 * np.pi))


def _slopes(x: Array) -> tuple[Array, Array]:
    """Return first and second derivative of log_ndtr."""
    from scipy.special import log_ndtr

    slope = np.exp(-(x**2) / 2 - np.log(2 * np.pi) / 2 - log_ndtr(x))
    return slope, -slope * (x + slope)


def _between(d: Array, t: Array) -> Array:
    """Return how likely a difference d is called none: in the tail, where both are small, exact."""
    from scipy.special import ndtr

    far = np.abs(d)
    return np.asarray(np.maximum(ndtr(t - far) - ndtr(-t - far), 1e-300))


def resampled_scores(wins: Array, ties: Array | None, resamples: int, seed: int) -> Scores:
    """Scale resamples of people. wins, ties: (people, n, n). Returns (resamples, n)."""
    people = len(wins)
    rng = np.random.default_rng(seed)
    drawn = rng.multinomial(people, np.full(people, 1 / people), size=resamples).astype(np.float64)
    return jod_scores(np.tensordot(drawn, wins, axes=1), None if ties is None else np.tensordot(drawn, ties, axes=1))


def left_out_scores(wins: Array, ties: Array | None) -> Scores:
    """Scale without each person in turn. wins, ties: (people, n, n). Returns scores (people, n)."""
    return jod_scores(wins.sum(axis=0) - wins, None if ties is None else ties.sum(axis=0) - ties)


def resampled_interval(found: float, resampled: Array, left_out: Array, level: float = 0.95) -> tuple[float, float]:
    """Return the ends of the BCa interval of `found`, widened for few people.

    resampled: in resamples of people. left_out: without each person. With the quantiles of
    Student's t and the variance of n - 1, as a dozen resampled people vary too little.
    Source: Efron 1987; Hesterberg 2015, The American Statistician 69 ("expanded percentile").
    """
    from scipy.special import ndtr, stdtrit

    people = len(left_out)
    tail = ndtr(np.sqrt(people / (people - 1)) * stdtrit(people - 1, (1 - level) / 2))
    near = 1e-9 * max(1.0, abs(found))  # scores of equal answers differ by where the search ended
    below = ((resampled < found - near).mean() + (resampled <= found + near).mean()) / 2
    below = np.clip(below, 0.5 / len(resampled), 1 - 0.5 / len(resampled))
    low, high = np.quantile(resampled, bca_shares(below, left_out, float(1 - 2 * tail)))
    return float(low), float(high)
