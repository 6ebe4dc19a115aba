"""The BCa interval against the enumeration of all resamples, and against SciPy's."""

from __future__ import annotations

import itertools
import math
from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from hmdwarp.study.statistics import bca, is_degenerate

RATED = np.array([0.25, 1.25, 2.0, 1.75, 2.0, 1.0, 1.25, 2.5, -0.25, 0.75, 3.0])
THIRDS = np.array([1, 4, -2, 5, 3, 3, 8]) / 3  # as means of three repeats are
QUARTERS = st.lists(st.integers(-12, 12).map(lambda steps: steps / 4), min_size=2, max_size=12)


def of_all_resamples(differences, level: float = 0.95) -> tuple[float, float]:
    """BCa of every multiset of n differences, weighted by the number of its arrangements."""
    d = np.asarray(differences)
    n, chance = len(d), Counter()
    for drawn in itertools.combinations_with_replacement(range(n), n):
        repeats = math.prod(math.factorial(count) for count in Counter(drawn).values())
        chance[round(float(d[list(drawn)].mean()), 9)] += math.factorial(n) / repeats / n**n
    means = sorted(chance)
    mean = round(float(d.mean()), 9)
    bias = stats.norm.ppf(sum(chance[value] for value in means if value < mean) + chance[mean] / 2)
    left_out = (d.sum() - d) / (n - 1)
    pulls = left_out.mean() - left_out
    a = (pulls**3).sum() / (6 * (pulls**2).sum() ** 1.5)
    ends = []
    for tail in ((1 - level) / 2, (1 + level) / 2):
        z = bias + stats.norm.ppf(tail)
        share = stats.norm.cdf(bias + z / (1 - a * z))
        ends.append(means[np.searchsorted(np.cumsum([chance[value] for value in means]), share)])
    return tuple(ends)


@pytest.mark.parametrize(
    "differences", [THIRDS, RATED[:8], [0.1, 0.2, 0.7, -0.4, 1.3], [0.0, 1.0], [0, 0, 0, 0, 0, 3.0]]
)
def test_ratings_in_steps_have_the_interval_of_all_resamples(differences):
    assert bca(differences) == pytest.approx(of_all_resamples(differences), abs=1e-8)
    assert bca(differences, seed=1, resamples=100) == bca(differences)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_drawn_resamples_come_within_two_steps_of_it(seed):
    # 20,000 resamples place a 2.5 % quantile to within 0.0011 of its share (one standard error),
    # less
    # than the share of most steps of the mean: the end is the right one or one of two neighbours.
    unit = np.sqrt(2)  # on no grid
    found = bca(RATED * unit, seed)
    assert found == pytest.approx([end * unit for end in bca(RATED)], abs=2 * unit * 0.25 / len(RATED) + 1e-9)
    assert found == bca(RATED * unit, seed)


def test_it_is_scipys_on_numbers_without_ties():
    differences = np.random.default_rng(3).gamma(2.0, 1.0, 30)
    expected = stats.bootstrap(
        (differences,), np.mean, n_resamples=20_000, method="BCa", rng=np.random.default_rng(5)
    ).confidence_interval
    # The standard error of a 2.5 % quantile of 20,000 draws of a mean with deviation s is about
    # 0.02 s; 5 of both together.
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


def test_the_seed_matters_where_resamples_are_drawn():
    differences = np.random.default_rng(7).normal(size=12)
    assert bca(differences, 1) == bca(differences, 1)
    assert len({bca(differences, seed, resamples=200) for seed in range(5)}) > 1


def test_infinite_input_is_refused():
    with pytest.raises(ValueError, match="finite"):
        bca([1.0, np.inf])
