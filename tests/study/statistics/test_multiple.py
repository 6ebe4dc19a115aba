"""Friedman, Kendall's W and Holm against their textbook formulas."""

from __future__ import annotations

import gc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from hmdwarp.study.statistics import friedman, holm, kendalls_w


def by_conover(table: np.ndarray) -> float:
    """chi2 with ties, Conover 1999, eq. 5.8.5, from the ranks."""
    ranks = np.array([stats.rankdata(row) for row in table])
    n, k = ranks.shape
    spread = ((ranks.sum(axis=0) - n * (k + 1) / 2) ** 2).sum()
    return (k - 1) * spread / ((ranks**2).sum() - n * k * (k + 1) ** 2 / 4)


def test_friedman_is_conovers_with_ties_and_missing_rows_left_out():
    table = np.random.default_rng(1).integers(4, 20, (12, 5)) / 4
    found = friedman(np.vstack([table, [[np.nan, 1, 2, 3, 4]]]))
    assert found.n == 12 and found.df == 4
    assert found.chi2 == pytest.approx(by_conover(table), rel=1e-12)
    assert found.p == pytest.approx(stats.chi2.sf(found.chi2, 4), rel=1e-12)


def test_full_agreement_has_a_w_of_1():
    table = np.array([[1.0, 2.0, 3.0], [2.0, 4.0, 5.0], [0.0, 0.5, 9.0]])
    assert kendalls_w(friedman(table)) == pytest.approx(1.0)


def test_friedman_needs_enough_conditions_and_people():
    assert friedman([[1.0, 2.0], [2.0, 1.0]]) is None  # two conditions are Wilcoxon's
    assert friedman([[1.0, 2.0, 3.0]]) is None
    assert friedman([[2.0, 2.0, 2.0], [3.0, 3.0, 3.0]]).p == 1.0  # where SciPy has 0 / 0


def test_w_is_that_of_pingouin():
    pingouin = pytest.importorskip("pingouin", reason="pingouin, an oracle for tests alone, is not installed")
    pandas = pytest.importorskip("pandas")
    table = np.random.default_rng(2).integers(4, 20, (10, 4)) / 4
    expected = pingouin.friedman(pandas.DataFrame(table))
    assert kendalls_w(friedman(table)) == pytest.approx(float(expected["W"].iloc[0]), rel=1e-9)


@settings(max_examples=20)
@given(st.lists(st.floats(0, 1), min_size=1, max_size=8))
def test_holm_is_that_of_statsmodels(ps):
    theirs = pytest.importorskip(
        "statsmodels.stats.multitest", reason="statsmodels is not installed (pip install '.[study]')"
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(gc, "collect", lambda generation=2: 0)  # it does so in each call
        expected = theirs.multipletests(ps, method="holm")[1]
    assert holm(ps) == pytest.approx(expected, abs=1e-15)


def test_holm_of_nothing():
    assert holm([]) == []
