"""The exact signed-rank test against all 2^n ways to give the signs, and what a p must be whatever
the data are.
"""

from __future__ import annotations

import itertools
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from hmdwarp.study.statistics import rank_biserial, smallest_p, wilcoxon_exact

QUARTERS = st.integers(-12, 12).map(lambda steps: steps / 4)  # many ties, many zeros, as grades have them
DIFFERENCES = st.lists(QUARTERS, min_size=1, max_size=9)


def by_enumeration(differences) -> Fraction:
    """The two-sided p with exact numbers.

    Of all signs, those whose larger sum is at least the one found.
    """
    steps = [round(4 * d) for d in differences if d]
    if not steps:
        return Fraction(1)
    ranks = [
        2 * sum(abs(o) < abs(s) for o in steps) + sum(abs(o) == abs(s) for o in steps) + 1 for s in steps
    ]  # doubled midranks
    found = max(
        sum(r for r, s in zip(ranks, steps, strict=True) if s > 0),
        sum(r for r, s in zip(ranks, steps, strict=True) if s < 0),
    )
    sums = [
        sum(r for r, positive in zip(ranks, signs, strict=True) if positive)
        for signs in itertools.product((0, 1), repeat=len(ranks))
    ]
    return min(Fraction(1), 2 * Fraction(sum(total >= found for total in sums), len(sums)))


@given(DIFFERENCES)
def test_p_is_what_counting_all_signs_gives(differences):
    # Halves and sums of at most 2^9 equal parts: every step is exact in float64.
    assert wilcoxon_exact(differences).p == float(by_enumeration(differences))


@given(DIFFERENCES)
def test_sums_are_of_the_midranks(differences):
    found = wilcoxon_exact(differences)
    kept = [d for d in differences if d]
    assert found.n == len(kept)
    assert found.w_plus + found.w_minus == len(kept) * (len(kept) + 1) / 2


@given(DIFFERENCES, st.randoms(use_true_random=False), st.sampled_from([0.1, 3.0, 1e-9, 1e9, 1 / 3]))
def test_order_and_unit_do_not_matter_and_signs_only_mirror(differences, random, scale):
    found = wilcoxon_exact(differences)
    shuffled = random.sample(differences, len(differences))
    assert wilcoxon_exact(shuffled) == found
    assert wilcoxon_exact([scale * d for d in differences]) == found  # a grade of 4.25 - 3.15 is no exact number either
    mirrored = wilcoxon_exact([-d for d in differences])
    assert (mirrored.w_plus, mirrored.w_minus, mirrored.p) == (found.w_minus, found.w_plus, found.p)
    assert rank_biserial([-d for d in differences]) == -rank_biserial(differences)


def test_without_ties_it_is_what_scipy_says():
    random = np.random.default_rng(1)
    for n in (5, 12, 30, 60):
        differences = random.normal(0.3, 1, n)
        expected = stats.wilcoxon(differences, method="exact")
        assert wilcoxon_exact(differences).p == pytest.approx(expected.pvalue, rel=1e-12)


def test_many_ties_of_many_people_agree_with_the_normal_curve():
    """A second route where enumeration cannot go.

    For 200 pairs the normal approximation with ties is good to a few percent.
    """
    differences = np.random.default_rng(2).integers(-8, 10, 200) / 4
    approximate = stats.wilcoxon(differences, method="approx", correction=True).pvalue
    assert wilcoxon_exact(differences).p == pytest.approx(approximate, rel=0.03)


def test_zero_differences_have_p_1():
    found = wilcoxon_exact([0.0, 0.0])
    assert found == (0.0, 0.0, 1.0, 0)
    assert rank_biserial([0.0, 0.0]) == 0.0
    assert wilcoxon_exact([]).p == 1.0


def test_the_smallest_p_is_reached_and_not_undercut():
    for n in range(1, 12):
        assert wilcoxon_exact(np.arange(1, n + 1)).p == smallest_p(n)
    assert smallest_p(0) == 1.0


@pytest.mark.parametrize("wrong", [[1.0, np.nan], [np.inf], [[1.0, 2.0]]])
def test_input_other_than_numbers_is_refused(wrong):
    with pytest.raises(ValueError, match="finite"):
        wilcoxon_exact(wrong)


def test_too_many_pairs_are_refused_rather_than_approximated():
    with pytest.raises(ValueError, match="1001 differences"):
        wilcoxon_exact(np.arange(1, 1002))


def test_rank_biserial_is_that_of_pingouin():
    pingouin = pytest.importorskip("pingouin", reason="pingouin, an oracle for tests alone, is not installed")
    first, second = np.array([3, 4, 5, 4.25, 2, 5, 1.5]), np.array([2.75, 3, 5, 2, 3, 3.25, 2])
    expected = pingouin.wilcoxon(first, second)
    assert rank_biserial(first - second) == pytest.approx(float(expected["RBC"].iloc[0]), abs=1e-12)
