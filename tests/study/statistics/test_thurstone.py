"""Scores from paired comparisons: the published model by another route; what one more tells."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import optimize, special, stats

from hmdwarp.study.statistics import JOD_SPREAD, jod_scores, resampled_interval, resampled_scores

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
