"""The BCa interval against SciPy's, and against the bootstrap of all resamples, which small lists of quarter steps allow."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from hmdwarp.study.statistics import bca, is_degenerate

RATED = np.array([0.25, 1.25, 2.0, 1.75, 2.0, 1.0, 1.25, 2.5, -0.25, 0.75, 3.0])
QUARTERS = st.lists(st.integers(-12, 12).map(lambda steps: steps / 4), min_size=2, max_size=12)


def of_all_resamples(differences, step: float, level: float = 0.95) -> tuple[float, float]:
    """BCa with the exact distribution of the resampled mean: n differences drawn are n throws of one die, so their sum is an n-fold
    convolution. Another route than drawing, and without its noise."""
    d = np.asarray(differences)
    n, units = len(d), np.rint(np.asarray(differences) / step).astype(int)
    die = np.bincount(units - units.min()) / n
    chance = np.array([1.0])
    for _ in range(n):
        chance = np.convolve(chance, die)
    means = (np.arange(len(chance)) + units.min() * n) * step / n
    middle = units.sum() - units.min() * n
    bias = stats.norm.ppf(chance[:middle].sum() + chance[middle] / 2)
    left_out = (d.sum() - d) / (n - 1)  # the jackknife itself, not the formula for the mean
    pulls = left_out.mean() - left_out
    a = (pulls**3).sum() / (6 * (pulls**2).sum() ** 1.5)
    ends = []
    for tail in ((1 - level) / 2, (1 + level) / 2):
        z = bias + stats.norm.ppf(tail)
        ends.append(means[np.searchsorted(np.cumsum(chance), stats.norm.cdf(bias + z / (1 - a * z)))])
    return tuple(ends)


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize(("differences", "step"), [(RATED, 0.25), ([0.5, -1.0, 0.25, 0.0, 2.0, 0.75, -0.5, 1.5], 0.25)])
def test_it_is_the_interval_of_all_resamples_but_for_a_step(differences, step, seed):
    # 20,000 resamples place a 2.5 % quantile to within 0.0011 of its share (one standard error), less than the share of most steps of
    # the mean: the end is the right one or a neighbour that has any share, at most two steps of step / n away.
    found, expected = bca(differences, seed), of_all_resamples(differences, step)
    assert np.abs(np.subtract(found, expected)).max() <= 2 * step / len(differences) + 1e-9


def test_it_is_scipys_on_numbers_without_ties():
    differences = np.random.default_rng(3).gamma(2.0, 1.0, 30)
    expected = stats.bootstrap(
        (differences,), np.mean, n_resamples=20_000, method="BCa", rng=np.random.default_rng(5)
    ).confidence_interval
    # The standard error of a 2.5 % quantile of 20,000 draws of a mean with deviation s is about 0.02 s; 5 of both together.
    error = differences.std() / np.sqrt(30) * 0.02 * np.sqrt(2) * 5
    assert bca(differences) == pytest.approx(tuple(expected), abs=error)


@settings(max_examples=30)
@given(QUARTERS, st.randoms(use_true_random=False))
def test_order_does_not_matter_and_signs_mirror(differences, random):
    found = bca(differences, resamples=500)
    assert bca(random.sample(differences, len(differences)), resamples=500) == found
    if sum(differences):  # a mean of 0 has no side to be turned to
        assert bca([-d for d in differences], resamples=500) == (-found.high, -found.low)
    assert min(differences) - 1e-9 <= found.low <= found.high <= max(differences) + 1e-9


def test_the_unit_does_not_matter():
    assert bca(1000 * RATED) == pytest.approx(tuple(1000 * end for end in bca(RATED)), rel=1e-9)


def test_no_spread_is_a_point_and_no_nan():
    assert bca([0.5] * 8) == (0.5, 0.5) and is_degenerate([0.5] * 8)
    assert bca([0.1 + 0.2, 0.3, 0.3]) == pytest.approx((0.3, 0.3))
    assert bca([2.0]) == (2.0, 2.0) and is_degenerate([2.0])
    assert np.isnan(bca([])).all()
    assert np.isfinite(bca([0, 0, 0, 0, 0, 0, 0, 3.0])).all()


def test_the_seed_is_all_that_chance_has():
    assert bca(RATED, 1) == bca(RATED, 1)
    assert len({bca(RATED, seed, resamples=200) for seed in range(5)}) > 1


def test_what_is_not_finite_is_refused():
    with pytest.raises(ValueError, match="finite"):
        bca([1.0, np.inf])
