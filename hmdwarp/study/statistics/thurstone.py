"""Scores from paired comparisons: Thurstone's Case V in units of just objectionable differences.

A difference of 1 JOD means that 75 % of answers prefer the better one. Scores are those of maximum
likelihood, with a wide prior that keeps them finite where everybody agrees; where "no difference"
may be answered, it has a threshold that is estimated beside the scores.
Source: Perez-Ortiz and Mantiuk 2017, A practical guide and software for analysing pairwise
comparison experiments, arXiv 1712.03686 (Case V, the unit, resampling people); their prior of
distances is replaced by a normal one of scores, which leaves one maximum. Glenn and David 1960,
Ties in paired-comparison experiments using a modified Thurstone-Mosteller model, Biometrics 16.
"""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray
from scipy.special import log_ndtr, ndtr, stdtrit

from .rank_tests import JOD_SPREAD, bca_shares

Array = NDArray[np.float64]

PRIOR_SD = 5.0  # of a score and of the threshold, JOD: a difference of 5 JOD is one that 99.96 % see
HALF_TIE = 0.5  # added to the ties, so that a resample without one still has a threshold
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
    at = _highest(_likelihood(wins, ties), n)
    threshold = at[:, n] if ties is not None else np.zeros(len(at))
    return Scores(at[:, :n].reshape(*shape, n) * JOD_SPREAD, threshold.reshape(shape) * JOD_SPREAD)


@attrs.frozen(eq=False)
class _Likelihood:
    """Log of the posterior density and its derivatives, for a batch of tables at once.

    Scores and threshold are in units of JOD_SPREAD here.
    """

    won: Array  # (batch, pairs)
    lost: Array
    tied: Array
    pairs: Array  # (pairs, n): 1 and -1
    has_ties: bool

    def value(self, at: Array) -> Array:
        """Return it (batch); -inf for a threshold that is not positive."""
        d, t = self._differences(at)
        found = (self.won * log_ndtr(d - t) + self.lost * log_ndtr(-d - t)).sum(axis=1)
        if self.has_ties:
            with np.errstate(divide="ignore", invalid="ignore"):
                found += (self.tied * np.log(_between(d, t))).sum(axis=1) + HALF_TIE * np.log(at[:, -1])
            found = np.where(at[:, -1] > 0, found, -np.inf)
        return np.asarray(found - (at**2).sum(axis=1) / (2 * self._prior))

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
        gradient, hessian = np.zeros(at.shape), np.zeros((*at.shape, at.shape[1]))
        gradient[:, :n] = by_d @ self.pairs - self._scores(at) / self._prior
        hessian[:, :n, :n] = np.einsum("bp,pi,pj->bij", by_dd, self.pairs, self.pairs, optimize=True)
        hessian[:, range(n), range(n)] -= 1 / self._prior
        if self.has_ties:
            gradient[:, n] = by_t.sum(axis=1) + HALF_TIE / at[:, n] - at[:, n] / self._prior
            hessian[:, n, n] = by_tt.sum(axis=1) - HALF_TIE / at[:, n] ** 2 - 1 / self._prior
            hessian[:, :n, n] = hessian[:, n, :n] = by_dt @ self.pairs
        return gradient, hessian

    @property
    def _prior(self) -> float:
        return (PRIOR_SD / JOD_SPREAD) ** 2

    def _scores(self, at: Array) -> Array:
        return at[:, : self.pairs.shape[1]]

    def _differences(self, at: Array) -> tuple[Array, Array]:
        return self._scores(at) @ self.pairs.T, at[:, -1:] if self.has_ties else np.zeros((len(at), 1))


def _likelihood(wins: Array, ties: Array | None) -> _Likelihood:
    """Make it of tables (.., n, n), all in one batch."""
    n = np.shape(wins)[-1]
    first, second = np.triu_indices(n, 1)
    tables = np.asarray(wins, np.float64).reshape(-1, n, n)
    won, lost = tables[:, first, second], tables[:, second, first]
    tied = np.zeros_like(won) if ties is None else np.asarray(ties, np.float64).reshape(-1, n, n)[:, first, second]
    return _Likelihood(won, lost, tied, np.eye(n)[first] - np.eye(n)[second], has_ties=ties is not None)


def _density(x: Array) -> Array:
    return np.asarray(np.exp(-(x**2) / 2) / np.sqrt(2 * np.pi))


def _slopes(x: Array) -> tuple[Array, Array]:
    """Return first and second derivative of log_ndtr."""
    slope = np.exp(-(x**2) / 2 - np.log(2 * np.pi) / 2 - log_ndtr(x))
    return slope, -slope * (x + slope)


def _between(d: Array, t: Array) -> Array:
    """Return how likely a difference d is called none: in the tail, where both are small, exact."""
    far = np.abs(d)
    return np.asarray(np.maximum(ndtr(t - far) - ndtr(-t - far), 1e-300))


def _highest(of: _Likelihood, n: int) -> Array:
    """Climb to the one maximum by Newton's steps, halved where they overshoot."""
    at = np.zeros((len(of.won), n + of.has_ties))
    if of.has_ties:
        at[:, n] = 0.3
    value = of.value(at)
    for _ in range(_STEPS):
        gradient, hessian = of.derivatives(at)
        step = np.linalg.solve(-hessian, gradient[..., None])[..., 0]
        if np.abs(step).max(initial=0.0) < _CLOSE:
            break
        scale = np.ones(len(at))
        while True:
            tried = of.value(at + scale[:, None] * step)
            low = (tried < value - 1e-9 * np.abs(value)) & (scale > 1e-6)
            if not low.any():
                break
            scale[low] /= 2
        at, value = at + scale[:, None] * step, tried
    return at


def resampled_scores(wins: Array, ties: Array | None, resamples: int, seed: int) -> Scores:
    """Scale resamples of people, each with all answers of theirs.

    wins, ties: (people, n, n). Returns scores (resamples, n).
    """
    people = len(wins)
    rng = np.random.default_rng(seed)
    drawn = rng.multinomial(people, np.full(people, 1 / people), size=resamples).astype(np.float64)

    def summed(of: Array) -> Array:
        return np.tensordot(drawn, of, axes=1)

    return jod_scores(summed(wins), None if ties is None else summed(ties))


def left_out_scores(wins: Array, ties: Array | None) -> Scores:
    """Scale without each person in turn. wins, ties: (people, n, n). Returns scores (people, n)."""
    return jod_scores(wins.sum(axis=0) - wins, None if ties is None else ties.sum(axis=0) - ties)


def resampled_interval(found: float, resampled: Array, left_out: Array, level: float = 0.95) -> tuple[float, float]:
    """Return the ends of the BCa interval of a number, widened for few people.

    found: the estimate. resampled: it in resamples of people. left_out: without each person.
    The quantiles are those of Student's t and the variance of n - 1: resampling few people varies
    too little, so that 95 % of a dozen people would be 92 %.
    Source: Efron 1987; Hesterberg 2015, What teachers should know about the bootstrap, The American
    Statistician 69 ("expanded percentile").
    """
    people = len(left_out)
    tail = ndtr(np.sqrt(people / (people - 1)) * stdtrit(people - 1, (1 - level) / 2))
    near = 1e-9 * max(1.0, abs(found))  # scores of equal answers differ by where the search ended
    below = ((resampled < found - near).mean() + (resampled <= found + near).mean()) / 2
    below = np.clip(below, 0.5 / len(resampled), 1 - 0.5 / len(resampled))
    low, high = np.quantile(resampled, bca_shares(below, left_out, float(1 - 2 * tail)))
    return float(low), float(high)
