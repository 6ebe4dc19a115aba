"""The analysis is right as often as it says, over 400 studies of people whose effects are known
(tests/study/coverage.py says how).
"""

from __future__ import annotations

import numpy as np
import pytest

from .coverage import LEVEL, bounds, coverage, designed, expected_bca, without_effect

STUDIES = 400


@pytest.mark.slow
@pytest.mark.parametrize("n", [12, 24])
def test_known_effects_come_back_inside_their_intervals_at_the_nominal_rate(n):
    found = coverage(*designed(), n, STUDIES, seed=1)
    assert found.dropped > 0.05  # with people who leave among them
    for k, _ in enumerate(found.comparisons):
        least, most = bounds(found.promised[:, k].mean(), STUDIES)
        # Exact where differences are continuous and symmetric; steps make many pairwise means equal
        # to the true one, which only adds.
        assert least <= found.latent_shift[:, k].mean() <= most
        assert found.shift[:, k].mean() >= least
        # The bootstrap of so few is short by a known amount, and by no more: what is promised is
        # what theory says, not 95 %.
        least, most = bounds(expected_bca(found.pairs[:, k]), STUDIES)
        assert least <= found.mean[:, k].mean() <= most


def test_the_bootstrap_of_a_mean_is_short_by_what_student_knew():
    """P(|t_11| < 1.96 sqrt(11/12)) and P(|t_23| < 1.96 sqrt(23/24)), from tables of t.

    None is left with many people.
    """
    assert expected_bca(np.array([12])) == pytest.approx(0.913, abs=0.001)
    assert expected_bca(np.array([24])) == pytest.approx(0.932, abs=0.001)
    assert expected_bca(np.array([10_000])) == pytest.approx(LEVEL, abs=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("n", [12, 24])
def test_no_effect_is_found_where_there_is_none(n):
    found = without_effect(*designed(), n, STUDIES, seed=2)
    most = bounds(1 - LEVEL, STUDIES)[1]
    assert found.any_found.mean() <= most  # Holm over three
    for level in (0.01, 0.05, 0.1, 0.2):
        assert ((found.p <= level).mean(axis=0) <= bounds(level, STUDIES)[1]).all()
