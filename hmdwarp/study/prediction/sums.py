"""Sums per person that predictions are made from: resampling people is a matrix product."""

from __future__ import annotations

from collections.abc import Hashable, Sequence

import attrs
import numpy as np
from numpy.typing import NDArray

from ..statistics import bca_shares

Array = NDArray[np.float64]


@attrs.frozen(eq=False)
class Sums:
    """Sums over each person's ratings, of products of centred measures x and ratings y."""

    xx: Array  # (people, measures)
    xy: Array  # (people, measures)
    yy: Array  # (people,)
    count: Array  # (people,), ratings

    @classmethod
    def of(cls, x: Array, y: Array, who: NDArray[np.intp]) -> Sums:
        """Sum x (n, m) and y (n,), both less each person's mean; who: (n,), person from 0 on."""
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
        """Number of people."""
        return len(self.yy)

    def only(self, people: NDArray[np.bool_]) -> Sums:
        """Return the sums of some people."""
        return Sums(self.xx[people], self.xy[people], self.yy[people], self.count[people])


def correlations(sums: Sums, weights: Array) -> Array:
    """Return repeated-measures correlations (draws, m), 0 where nothing varies.

    weights: (draws, people), how often each draw counts each person.
    """
    size = np.sqrt((weights @ sums.xx) * (weights @ sums.yy)[:, None])
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(size > 0, (weights @ sums.xy) / size, 0.0)


def bca_intervals(found: Array, resampled: Array, jackknifed: Array) -> tuple[Array, Array]:
    """Return the ends (m,) of 95 % BCa intervals.

    found: (m,), resampled: (draws, m), jackknifed: (people, m).
    """
    # Ties count half: with few people many draws give the very same.
    below = ((resampled < found).mean(axis=0) + (resampled <= found).mean(axis=0)) / 2
    below = np.clip(below, 0.5 / len(resampled), 1 - 0.5 / len(resampled))
    shares = bca_shares(below, jackknifed)
    low, high = (
        np.array([np.quantile(resampled[:, k], share[k]) for k in range(len(found))], np.float64) for share in shares
    )
    return low, high


def sign_flips(people: int, draws: int, rng: np.random.Generator) -> Array:
    """Return patterns (n, people) of +1 and -1, the one without a flip first.

    All of them where they are no more than `draws`, else so many drawn at random.
    """
    if 2**people <= draws:
        return 1.0 - 2.0 * ((np.arange(2**people)[:, None] >> np.arange(people)) & 1).astype(np.float64)
    return np.vstack([np.ones((1, people)), rng.choice((-1.0, 1.0), size=(draws - 1, people))])


def shares_of_people(sums: Sums) -> Array:
    """Return what each person adds to each measure's correlation: (people, m), summing to it."""
    return np.asarray(sums.xy / np.sqrt(sums.xx.sum(axis=0) * sums.yy.sum()))


def p_of_any(shares: Array, flips: Array) -> Array:
    """Return p (m,) of no association of any measure with the ratings.

    Without an association each person's share is as likely to be its opposite. p is how often the
    largest of all |r| is as large as this one: exact where all flips are tried, and corrected for
    testing all measures.
    """
    largest = np.abs(flips @ shares).max(axis=1)
    return np.asarray((largest[:, None] >= np.abs(shares.sum(axis=0)) - 1e-12).mean(axis=0))


def p_of_behind(shares: Array, best: int, flips: Array) -> Array:
    """Return p (m,) of being no worse than the best measure.

    The difference of their |r| is a sum over people; each term is as likely to be its opposite.
    """
    turned = shares * np.where(shares.sum(axis=0) < 0, -1.0, 1.0)
    ahead = turned[:, [best]] - turned
    return np.asarray((np.abs(flips @ ahead) >= np.abs(ahead.sum(axis=0)) - 1e-12).mean(axis=0))


def skill_of_left_out_people(sums: Sums, drawn: Array) -> tuple[Array, Array, Array, Array]:
    """Predict each person from their own mean and the slope of all others: leave-one-person-out.

    Return (skill, low, high, rmse), each (m,). skill: 1 less the squared error over that of the
    mean alone. low, high: 95 % percentiles over resampled people.
    """
    error = _errors_of_left_out(sums)
    total = error.sum(axis=0)
    return *_skill(sums, error, drawn), np.sqrt(np.maximum(total, 0) / sums.count.sum())


def skill_of_choice(sums: Sums, drawn: Array) -> tuple[float, float, float, NDArray[np.intp]]:
    """Predict each person by the measure that predicts best among all others: nested.

    For each person the others choose the measure, by leaving out each of them in turn, and give its
    slope. So no one's ratings take part in the choice that is tested on them, as they do in the
    skill of the measure that came first.

    Return (skill, low, high, chosen): as skill_of_left_out_people, and for each person the index of
    the measure. Source: Varma and Simon 2006, Bias in error estimation when using cross-validation
    for model selection, BMC Bioinformatics 7, 91.
    """
    everybody = np.arange(sums.people)
    chosen = np.array(
        [np.argmin(_errors_of_left_out(sums.only(everybody != person)).sum(axis=0)) for person in everybody],
        dtype=np.intp,
    )
    error = _errors_of_left_out(sums)[everybody, chosen]
    skill, low, high = _skill(sums, error[:, None], drawn)
    return float(skill[0]), float(low[0]), float(high[0]), chosen


def _errors_of_left_out(sums: Sums) -> Array:
    """Return each person's squared error by each measure with the slope of all others."""
    with np.errstate(invalid="ignore", divide="ignore"):
        xx = sums.xx.sum(axis=0) - sums.xx
        slope = np.where(xx > 0, (sums.xy.sum(axis=0) - sums.xy) / xx, 0.0)
    return sums.yy[:, None] - 2 * slope * sums.xy + slope**2 * sums.xx


def _skill(sums: Sums, error: Array, drawn: Array) -> tuple[Array, Array, Array]:
    """Return the share of squared error that is removed, and its percentiles over people."""
    alone = np.maximum(drawn @ sums.yy, 1e-300)
    low, high = np.percentile(1 - (drawn @ error) / alone[:, None], (2.5, 97.5), axis=0)
    return 1 - error.sum(axis=0) / sums.yy.sum(), low, high


def skill_of_left_out_conditions(x: Array, y: Array, who: NDArray[np.intp], conditions: Sequence[Hashable]) -> Array:
    """Predict each condition from all others, people's means included; return the skill (m,).

    NaN where no condition can be left out. x: (n, m), y: (n,), not centred.
    """
    names = list(dict.fromkeys(conditions))
    which = np.array([names.index(condition) for condition in conditions])
    error, alone = np.zeros(x.shape[1]), 0.0
    for left_out in range(len(names)):
        known, left = which != left_out, which == left_out
        left &= np.isin(who, np.unique(who[known]))  # people without other ratings have no mean
        if not left.any():
            continue
        mean_x, mean_y = _means(x[known], who[known]), _means(y[known, None], who[known])
        dx, dy = x[known] - mean_x[who[known]], (y[known, None] - mean_y[who[known]])[:, 0]
        size = (dx * dx).sum(axis=0)
        slope = np.divide(dx.T @ dy, size, out=np.zeros_like(size), where=size > 0)
        off = y[left, None] - mean_y[who[left]]
        error += ((off - slope * (x[left] - mean_x[who[left]])) ** 2).sum(axis=0)
        alone += float((off**2).sum())
    return 1 - error / alone if alone > 0 else np.full(x.shape[1], np.nan)


def _means(values: Array, who: NDArray[np.intp]) -> Array:
    """Return means (people, m); people without values get 0, which is not used."""
    out = np.zeros((int(who.max()) + 1, values.shape[1]))
    np.add.at(out, who, values)
    return out / np.maximum(np.bincount(who, minlength=len(out)), 1)[:, None]
