"""Exact tests and intervals of small samples, power and scores, by other routes.

Enumeration, SciPy, pingouin, statsmodels, closed forms; what they must be whatever the data are.
"""

from __future__ import annotations

import gc
import itertools
import json
import math
from collections import Counter
from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas
import pytest
from commands import hmdwarp
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import optimize, special, stats
from scipy.special import ndtr
from scipy.stats import binom, binomtest
from together import together

from hmdwarp.study.design import power_as_json, power_rows
from hmdwarp.study.statistics import (
    JOD_SPREAD,
    attained_level,
    bca,
    friedman,
    hodges_lehmann,
    holm,
    is_degenerate,
    jod_scores,
    kendalls_w,
    people_for_sign,
    people_for_signed_rank,
    rank_biserial,
    resampled_interval,
    resampled_scores,
    sign_power,
    signed_rank_power,
    smallest_p,
    wilcoxon_exact,
)

from ..analysis.tables import pairs_of

QUARTERS = st.integers(-12, 12).map(lambda steps: steps / 4)  # many ties, many zeros, as grades have them
DIFFERENCES = st.lists(QUARTERS, min_size=1, max_size=12)
RANDOMS = st.randoms(use_true_random=False)
RATED = np.array([0.25, 1.25, 2.0, 1.75, 2.0, 1.0, 1.25, 2.5, -0.25, 0.75, 3.0])
THIRDS = np.array([1, 4, -2, 5, 3, 3, 8]) / 3  # as means of three repeats are


def test_input_other_than_numbers_is_refused():
    for wrong in ([1.0, np.nan], [np.inf], [[1.0, 2.0]]):
        with pytest.raises(ValueError, match="finite"):
            wilcoxon_exact(wrong)
    for of in (hodges_lehmann, bca):
        with pytest.raises(ValueError, match="finite"):
            of([1.0, np.inf])
    with pytest.raises(ValueError, match="1001 differences"):  # rather than approximated
        wilcoxon_exact(np.arange(1, 1002))


def test_nothing_and_zeros_have_p_1_and_no_shift():
    assert wilcoxon_exact([0.0, 0.0]) == (0.0, 0.0, 1.0, 0)
    assert rank_biserial([0.0, 0.0]) == 0.0
    assert wilcoxon_exact([]).p == smallest_p(0) == 1.0
    assert np.isnan(hodges_lehmann([])).all() and np.isnan(bca([])).all()
    assert holm([]) == []


# --- the signed-rank test


def by_enumeration(differences) -> Fraction:
    """The two-sided p with exact numbers. Of all 2^n signs, those whose larger sum is at least the
    one found.
    """
    steps = [round(4 * d) for d in differences if d]
    # Doubled midranks.
    ranks = [2 * sum(abs(o) < abs(s) for o in steps) + sum(abs(o) == abs(s) for o in steps) + 1 for s in steps]
    plus = sum(rank for rank, step in zip(ranks, steps, strict=True) if step > 0)
    found = max(plus, sum(ranks) - plus)
    sums = [sum(itertools.compress(ranks, signs)) for signs in itertools.product((0, 1), repeat=len(ranks))]
    return min(Fraction(1), 2 * Fraction(sum(total >= found for total in sums), len(sums)))


@given(st.lists(QUARTERS, min_size=1, max_size=9))
def test_p_is_what_counting_all_signs_gives(differences):
    # Halves and sums of at most 2^9 equal parts: every step is exact in float64.
    found = wilcoxon_exact(differences)
    assert found.p == float(by_enumeration(differences))
    assert found.n == len([d for d in differences if d])
    assert found.w_plus + found.w_minus == found.n * (found.n + 1) / 2


@given(DIFFERENCES, RANDOMS, st.sampled_from([0.1, 3.0, 1e-9, 1e9, 1 / 3]))
def test_order_and_unit_do_not_matter_and_signs_only_mirror(differences, random, scale):
    found = wilcoxon_exact(differences)
    shuffled = random.sample(differences, len(differences))
    assert wilcoxon_exact(shuffled) == found
    assert wilcoxon_exact([scale * d for d in differences]) == found  # a grade of 4.25 - 3.15 is no exact number either
    mirrored = wilcoxon_exact([-d for d in differences])
    assert (mirrored.w_plus, mirrored.w_minus, mirrored.p) == (found.w_minus, found.w_plus, found.p)
    assert rank_biserial([-d for d in differences]) == -rank_biserial(differences)
    interval = bca(differences, resamples=500)
    assert bca(shuffled, resamples=500) == interval
    if sum(differences):  # a mean of 0 has no side to be turned to
        assert bca([-d for d in differences], resamples=500) == (-interval.high, -interval.low)
    assert min(differences) - 1e-9 <= interval.low <= interval.high <= max(differences) + 1e-9


def test_it_agrees_with_scipy_and_pingouin():
    random = np.random.default_rng(1)
    for n in (5, 12, 30, 60):
        differences = random.normal(0.3, 1, n)
        expected = stats.wilcoxon(differences, method="exact")
        assert wilcoxon_exact(differences).p == pytest.approx(expected.pvalue, rel=1e-12)
    # With ties, where enumeration cannot go: for 200 pairs the normal approximation is good to a
    # few percent.
    differences = np.random.default_rng(2).integers(-8, 10, 200) / 4
    approximate = stats.wilcoxon(differences, method="approx", correction=True).pvalue
    assert wilcoxon_exact(differences).p == pytest.approx(approximate, rel=0.03)
    pingouin = pytest.importorskip("pingouin", reason="pingouin, an oracle for tests alone, is not installed")
    first, second = np.array([3, 4, 5, 4.25, 2, 5, 1.5]), np.array([2.75, 3, 5, 2, 3, 3.25, 2])
    expected = float(pingouin.wilcoxon(first, second)["RBC"].iloc[0])
    assert rank_biserial(first - second) == pytest.approx(expected, abs=1e-12)


def test_the_smallest_p_is_reached_and_not_undercut():
    for n in range(1, 12):
        assert wilcoxon_exact(np.arange(1, n + 1)).p == smallest_p(n)


# --- the Hodges-Lehmann shift


@together("n, level", itertools.product([6, 9, 12, 20], [0.9, 0.95]))
def test_the_interval_is_the_test_turned_round(n, level):
    """It holds exactly the shifts that the exact test does not reject."""
    differences = np.random.default_rng(n).normal(0.5, 1, n)
    found = hodges_lehmann(differences, level)
    inside, outside = np.linspace(found.low, found.high, 41)[1:-1], [found.low - 1e-6, found.high + 1e-6]
    assert all(wilcoxon_exact(differences - shift).p > 1 - level for shift in inside)
    assert all(wilcoxon_exact(differences - shift).p <= 1 - level for shift in outside)


def test_the_level_is_the_one_that_is_attained():
    # Of six, the interval from the least to the largest difference misses where all signs agree: 2
    # of 64.
    assert attained_level(6) == 1 - 2 / 64
    assert attained_level(5) == 1 - 2 / 32  # less than asked for: five cannot give 95 %
    assert all(0.95 <= attained_level(n) < 0.97 for n in range(7, 60)) and attained_level(1) == 0.0


@given(DIFFERENCES, st.integers(-8, 8))
def test_it_is_the_median_of_all_means_of_two_and_moves_and_mirrors_with_the_data(differences, move):
    pairs = [(a + b) / 2 for i, a in enumerate(differences) for b in differences[i:]]
    found = hodges_lehmann(differences)
    assert found.shift == np.median(pairs)
    assert min(differences) <= found.low <= found.shift <= found.high <= max(differences)
    assert hodges_lehmann([d + move for d in differences]) == tuple(value + move for value in found)
    assert hodges_lehmann([-d for d in differences]) == (-found.shift, -found.high, -found.low)


# --- the bootstrap


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


@together("differences", [THIRDS, RATED[:8], [0.1, 0.2, 0.7, -0.4, 1.3], [0.0, 1.0], [0, 0, 0, 0, 0, 3.0]])
def test_ratings_in_steps_have_the_interval_of_all_resamples(differences):
    assert bca(differences) == pytest.approx(of_all_resamples(differences), abs=1e-8)
    assert bca(differences, seed=1, resamples=100) == bca(differences)


def test_it_is_scipys_on_numbers_without_ties_and_the_seed_matters_there():
    differences = np.random.default_rng(3).gamma(2.0, 1.0, 30)
    drawn = {"n_resamples": 20_000, "method": "BCa", "rng": np.random.default_rng(5)}
    expected = stats.bootstrap((differences,), np.mean, **drawn).confidence_interval
    # The standard error of a 2.5 % quantile of 20,000 draws of a mean with deviation s is about
    # 0.02 s; 5 of both together.
    error = differences.std() / np.sqrt(30) * 0.02 * np.sqrt(2) * 5
    assert bca(differences) == pytest.approx(tuple(expected), abs=error)
    assert len({bca(differences, seed, resamples=200) for seed in range(5)}) > 1


def test_no_spread_is_a_point_and_no_nan():
    assert bca([0.5] * 8) == (0.5, 0.5) and is_degenerate([0.5] * 8)
    assert bca([0.1 + 0.2, 0.3, 0.3]) == pytest.approx((0.3, 0.3))
    assert bca([2.0]) == (2.0, 2.0) and is_degenerate([2.0])
    assert np.isfinite(bca([0, 0, 0, 0, 0, 0, 0, 3.0])).all()


# --- several conditions, several comparisons


def test_friedman_is_scipys_with_ties_and_missing_rows_left_out():
    table = np.random.default_rng(1).integers(4, 20, (12, 5)) / 4
    found = friedman(np.vstack([table, [[np.nan, 1, 2, 3, 4]]]))
    assert found.n == 12 and found.df == 4
    expected = stats.friedmanchisquare(*table.T)
    assert (found.chi2, found.p) == pytest.approx((expected.statistic, expected.pvalue), rel=1e-12)
    assert friedman([[1.0, 2.0], [2.0, 1.0]]) is None  # two conditions are Wilcoxon's
    assert friedman([[1.0, 2.0, 3.0]]) is None
    assert friedman([[2.0, 2.0, 2.0], [3.0, 3.0, 3.0]]).p == 1.0  # where SciPy has 0 / 0


def test_w_is_1_in_full_agreement_and_that_of_pingouin():
    assert kendalls_w(friedman([[1.0, 2.0, 3.0], [2.0, 4.0, 5.0], [0.0, 0.5, 9.0]])) == pytest.approx(1.0)
    pingouin = pytest.importorskip("pingouin", reason="pingouin, an oracle for tests alone, is not installed")
    table = np.random.default_rng(2).integers(4, 20, (10, 4)) / 4
    expected = pingouin.friedman(pandas.DataFrame(table))
    assert kendalls_w(friedman(table)) == pytest.approx(float(expected["W"].iloc[0]), rel=1e-9)


@settings(max_examples=20)
@given(st.lists(st.floats(0, 1), min_size=1, max_size=8))
def test_holm_is_that_of_statsmodels(ps):
    why = "statsmodels is not installed (pip install '.[study]')"
    theirs = pytest.importorskip("statsmodels.stats.multitest", reason=why)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(gc, "collect", lambda generation=2: 0)  # it does so in each call
        expected = theirs.multipletests(ps, method="holm")[1]
    assert holm(ps) == pytest.approx(expected, abs=1e-15)


DOCS = (Path(__file__).parents[3] / "docs" / "study-analysis.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("effect", [0.0, 0.5, 1.2])
def test_six_people_must_all_differ_in_one_direction(effect):
    assert signed_rank_power(6, effect, 0.05) == pytest.approx(ndtr(effect) ** 6 + ndtr(-effect) ** 6, abs=1e-9)
    assert signed_rank_power(5, effect, 0.05) == 0


@pytest.mark.parametrize(("effect", "people"), [(0.3, 94), (0.5, 35)])
def test_published_numbers_of_people(effect, people):
    """G*Power 3.1 (Faul et al. 2007) for normal parents, two-sided, 5 % and 80 %. It takes
    Student's number divided by the efficiency 3 / pi of Hodges and Lehmann 1956.
    """
    assert people_for_signed_rank(effect, 0.05) == people
    assert signed_rank_power(people - 1, effect, 0.05) < 0.8 <= signed_rank_power(people, effect, 0.05)


@pytest.mark.parametrize(("people", "share"), [(5, 0.9), (17, 0.75), (40, 0.5)])
def test_the_sign_test_is_that_of_all_counts(people, share):
    found = sum(binom.pmf(k, people, share) for k in range(people + 1) if binomtest(k, people).pvalue <= 0.05)
    assert sign_power(people, share, 0.05) == pytest.approx(found, abs=1e-12)


def test_more_people_than_enough_are_enough():
    enough = people_for_sign(0.75, 0.05)
    assert sign_power(enough - 1, 0.75, 0.05) < 0.8
    assert all(sign_power(people, 0.75, 0.05) >= 0.8 for people in range(enough, 3 * enough))


def test_the_plan_says_the_power_of_its_test_and_what_it_assumes():
    whole = hmdwarp("study", "plan", "quick", "--people", "24").stdout
    assert "Power of one comparison" + DOCS.split("```text\nPower of one comparison")[1].split("```")[0] in whole
    said = " ".join(whole.split())
    assert "exact signed-rank test, p below 0.05 / 2" in said
    assert "independent people" in said and "which is normal" in said
    (found,) = json.loads(hmdwarp("study", "plan", "quick", "--people", "24", "--json").stdout)["power"]
    for row in found["effects"]:
        assert row["power"] == signed_rank_power(24, row["effect"], 0.05 / 2)
        assert f"{row['effect']:g} sd {row['power']:.0%} with 24 people" in said
        assert f"80% with {row['people_for_80_percent']} " in said


def test_a_plan_of_pairs_has_that_of_the_sign_test():
    (found,) = power_as_json(pairs_of(), 30)
    expected = [sign_power(30, ndtr(jod / JOD_SPREAD), 0.05 / 2) for jod in (0.5, 1, 1.5)]
    assert [row["power"] for row in found["effects"]] == pytest.approx(expected, rel=1e-12)
    said = dict(power_rows(found))
    assert said["test"].startswith("exact sign test, p below 0.05 / 2") and "1 JOD, 75% of all" in said["assumed"]
    assert said["1 JOD"] == f"{expected[1]:.0%} with 30 people, 80% with {people_for_sign(0.75, 0.05 / 2)}"


PRIOR_SD = 5.0


def made_up(seed: int, n: int = 5, most: int = 12) -> tuple[np.ndarray, np.ndarray]:
    """Tables of wins and ties, some pairs never compared, some unanimous."""
    rng = np.random.default_rng(seed)
    wins = rng.integers(0, most, (n, n)).astype(float) * (rng.random((n, n)) < 0.7)
    np.fill_diagonal(wins, 0)
    ties = np.triu(rng.integers(0, 4, (n, n)).astype(float), 1)
    return wins, ties + ties.T


def test_one_jod_is_three_in_four():
    """The unit: 75 of 100 prefer it. The prior draws one JOD in by less than 3 %: its weight 1/25
    each score stands against an information of over 25 in 100 answers.
    """
    scores = jod_scores(np.array([[0, 75], [25, 0]])).jod
    assert scores[0] - scores[1] == pytest.approx(1.0, rel=0.03)
    assert scores.sum() == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("has_ties", [False, True])
def test_it_is_the_maximum_of_the_published_likelihood(seed, has_ties):
    """A search that knows no derivatives comes to the same place."""
    wins, ties = made_up(seed)
    found = jod_scores(wins, ties if has_ties else None)

    def less(at: np.ndarray) -> float:
        threshold = np.exp(at[-1]) if has_ties else 0.0
        half_tie = 0.5 * np.log(threshold) if has_ties else 0.0
        jod = at[: len(wins)]
        total = -float((jod**2).sum() + threshold**2) / (2 * PRIOR_SD**2)
        for i in range(len(jod)):
            for j in range(len(jod)):
                total += wins[i, j] * special.log_ndtr((jod[i] - jod[j] - threshold) / JOD_SPREAD)
                if j > i and threshold > 0:
                    d, size = (jod[i] - jod[j]) / JOD_SPREAD, threshold / JOD_SPREAD
                    total += ties[i, j] * np.log(special.ndtr(d + size) - special.ndtr(d - size))
        return -total - half_tie

    start = np.zeros(len(wins) + has_ties)
    other = optimize.minimize(less, start, method="BFGS", options={"gtol": 1e-4})
    assert found.jod == pytest.approx(other.x[: len(wins)], abs=1e-3)  # a slope of 1e-4 over a curvature of 1 and more
    if has_ties:
        assert found.threshold == pytest.approx(np.exp(other.x[-1]), abs=1e-3)


def test_many_tables_at_once_are_as_one_by_one():
    wins, ties = (np.array([made_up(seed)[k] for seed in range(6)]) for k in (0, 1))
    together = jod_scores(wins, ties)
    for k in range(6):
        alone = jod_scores(wins[k], ties[k])
        assert together.jod[k] == pytest.approx(alone.jod, abs=1e-8)
        assert together.threshold[k] == pytest.approx(alone.threshold, abs=1e-8)


def test_unanimous_and_missing_answers_give_finite_scores():
    """Unanimous answers have a finite score, and conditions without any lie in the middle."""
    wins = np.zeros((3, 3))
    wins[0, 1] = 1000
    scores = jod_scores(wins).jod
    assert np.isfinite(scores).all()
    assert 4 < scores[0] - scores[1] < 20
    assert scores[2] == pytest.approx(0, abs=1e-9)
    assert jod_scores(np.zeros((3, 3)), np.zeros((3, 3))).jod == pytest.approx(0)


def test_few_people_have_wider_intervals():
    """Without skew or bias the ends are those of Hesterberg's table: Student's t of n - 1."""
    drawn = np.arange(100_001.0)

    def ends(people: int):
        return resampled_interval(50_000.0, drawn, np.resize([-1.0, 1.0], people))

    low, high = ends(10)
    assert low == pytest.approx(100_000 * stats.norm.cdf(np.sqrt(10 / 9) * stats.t.ppf(0.025, 9)), abs=1)
    assert low + high == pytest.approx(100_000, abs=1)
    assert ends(10_000)[0] == pytest.approx(2500, abs=5)


def test_resamples_take_whole_people():
    """Two people who contradict each other: resamples are both, or one of them twice."""
    wins = np.zeros((2, 2, 2))
    wins[0, 0, 1] = wins[1, 1, 0] = 10
    drawn = resampled_scores(wins, None, 200, seed=1).jod[:, 0]
    assert len(np.unique(drawn.round(6))) == 3
    assert np.array_equal(drawn, resampled_scores(wins, None, 200, seed=1).jod[:, 0])
