"""Power of the exact tests, and scores from paired comparisons, by other routes."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from commands import hmdwarp
from scipy import optimize, special, stats
from scipy.special import ndtr
from scipy.stats import binom, binomtest

from hmdwarp.study.design import power_as_json, power_rows
from hmdwarp.study.statistics import (
    JOD_SPREAD,
    jod_scores,
    people_for_sign,
    people_for_signed_rank,
    resampled_interval,
    resampled_scores,
    sign_power,
    signed_rank_power,
)

from ..analysis.tables import pairs_of

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
