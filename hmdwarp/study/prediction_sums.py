"""The sums that predictions are made from: one of each person, so that drawing people anew is a product of matrices."""

from __future__ import annotations

from collections.abc import Hashable, Sequence

import attrs
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@attrs.frozen(eq=False)
class Sums:
    """Of products of centred measures x and ratings y, over each person's ratings: xx, xy (people, measures), yy, count (people,)."""

    xx: Array
    xy: Array
    yy: Array
    count: Array

    @classmethod
    def of(cls, x: Array, y: Array, who: NDArray[np.intp]) -> Sums:
        """x: (n, m), y: (n,), both less each person's mean. who: (n,), whose, from 0 on."""
        people = int(who.max()) + 1

        def over(values: Array) -> Array:
            out = np.zeros((people, *values.shape[1:]))
            np.add.at(out, who, values)
            return out

        return cls(
            over(x * x), over(x * y[:, None]), over(y * y), np.bincount(who, minlength=people).astype(np.float64)
        )

    @property
    def people(self) -> int:
        """How many."""
        return len(self.yy)


def correlations(sums: Sums, weights: Array) -> Array:
    """(draws, m) repeated-measures correlations with each person counted weights (draws, people) times; 0 where nothing moves."""
    size = np.sqrt((weights @ sums.xx) * (weights @ sums.yy)[:, None])
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(size > 0, (weights @ sums.xy) / size, 0.0)


def bca_intervals(found: Array, resampled: Array, jackknifed: Array, level: float = 0.95) -> tuple[Array, Array]:
    """Bias-corrected and accelerated percentiles. found (m,), resampled (draws, m), jackknifed (people, m). Source: Efron 1987."""
    from scipy.stats import norm

    # Ties count half: with few people many draws give the very same.
    below = ((resampled < found).mean(axis=0) + (resampled <= found).mean(axis=0)) / 2
    z0 = norm.ppf(np.clip(below, 0.5 / len(resampled), 1 - 0.5 / len(resampled)))
    d = jackknifed.mean(axis=0) - jackknifed
    spread = (d**2).sum(axis=0) ** 1.5
    a = np.divide((d**3).sum(axis=0), 6 * spread, out=np.zeros_like(spread), where=spread > 0)
    ends = []
    for z in norm.ppf(((1 - level) / 2, (1 + level) / 2)):
        share = norm.cdf(z0 + (z0 + z) / (1 - a * (z0 + z)))
        ends.append(np.array([np.quantile(resampled[:, k], share[k]) for k in range(len(found))]))
    return ends[0], ends[1]


def sign_flips(people: int, draws: int, rng: np.random.Generator) -> Array:
    """(n, people) of +1 and -1: all there are where that is no more than `draws`, else so many drawn, with the one without a flip first."""
    if 2**people <= draws:
        return 1.0 - 2.0 * ((np.arange(2**people)[:, None] >> np.arange(people)) & 1)
    return np.vstack([np.ones((1, people)), rng.choice((-1.0, 1.0), size=(draws - 1, people))])


def shares_of_people(sums: Sums) -> Array:
    """(people, m): what each person adds to each measure's correlation; they add up to it."""
    return sums.xy / np.sqrt(sums.xx.sum(axis=0) * sums.yy.sum())


def p_of_any(shares: Array, flips: Array) -> Array:
    """(m,) p of no association of any measure with the ratings, in which each person's share is as likely to be its opposite: how often
    the largest of all |r| is as large as this one. Exact where all flips are tried; right for all measures at once."""
    largest = np.abs(flips @ shares).max(axis=1)
    return (largest[:, None] >= np.abs(shares.sum(axis=0)) - 1e-12).mean(axis=0)


def p_of_behind(shares: Array, best: int, flips: Array) -> Array:
    """(m,) p of being no worse than the best: its |r| less theirs is a sum over people, each of which is as likely to be its opposite."""
    turned = shares * np.where(shares.sum(axis=0) < 0, -1.0, 1.0)
    ahead = turned[:, [best]] - turned
    return (np.abs(flips @ ahead) >= np.abs(ahead.sum(axis=0)) - 1e-12).mean(axis=0)


def skill_of_left_out_people(sums: Sums, drawn: Array) -> tuple[Array, Array, Array, Array]:
    """(skill, low, high, rmse), each (m,): one person after the other is predicted from their own mean and the slope of all others.

    skill: 1 less the squared error over that of the mean alone. low, high: 95 % percentiles with each person's error drawn anew.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        xx = sums.xx.sum(axis=0) - sums.xx
        slope = np.where(xx > 0, (sums.xy.sum(axis=0) - sums.xy) / xx, 0.0)
    error = sums.yy[:, None] - 2 * slope * sums.xy + slope**2 * sums.xx
    alone = np.maximum(drawn @ sums.yy, 1e-300)
    low, high = np.percentile(1 - (drawn @ error) / alone[:, None], (2.5, 97.5), axis=0)
    total = error.sum(axis=0)
    return 1 - total / sums.yy.sum(), low, high, np.sqrt(np.maximum(total, 0) / sums.count.sum())


def skill_of_left_out_conditions(x: Array, y: Array, who: NDArray[np.intp], conditions: Sequence[Hashable]) -> Array:
    """(m,): one condition after the other is predicted from what the other conditions told, means of people among it; NaN where no
    condition can be left out. x: (n, m), y: (n,), not centred."""
    names = list(dict.fromkeys(conditions))
    which = np.array([names.index(one) for one in conditions])
    error, alone = np.zeros(x.shape[1]), 0.0
    for left_out in range(len(names)):
        known, asked = which != left_out, which == left_out
        asked &= np.isin(who, np.unique(who[known]))  # of others nothing is known
        if not asked.any():
            continue
        mean_x, mean_y = _means(x[known], who[known]), _means(y[known, None], who[known])
        dx, dy = x[known] - mean_x[who[known]], (y[known, None] - mean_y[who[known]])[:, 0]
        size = (dx * dx).sum(axis=0)
        slope = np.divide(dx.T @ dy, size, out=np.zeros_like(size), where=size > 0)
        off = y[asked, None] - mean_y[who[asked]]
        error += ((off - slope * (x[asked] - mean_x[who[asked]])) ** 2).sum(axis=0)
        alone += float((off**2).sum())
    return 1 - error / alone if alone > 0 else np.full(x.shape[1], np.nan)


def _means(values: Array, who: NDArray[np.intp]) -> Array:
    """(people, m); those without any get a mean that is not used."""
    out = np.zeros((int(who.max()) + 1, values.shape[1]))
    np.add.at(out, who, values)
    return out / np.maximum(np.bincount(who, minlength=len(out)), 1)[:, None]
