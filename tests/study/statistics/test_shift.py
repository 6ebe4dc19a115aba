"""The Hodges-Lehmann shift.

The interval holds exactly the shifts that the exact test does not reject.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmdwarp.study.statistics import attained_level, hodges_lehmann, wilcoxon_exact

QUARTERS = st.lists(st.integers(-12, 12).map(lambda steps: steps / 4), min_size=1, max_size=14)


@pytest.mark.parametrize("n", [6, 9, 12, 20])
@pytest.mark.parametrize("level", [0.9, 0.95])
def test_the_interval_is_the_test_turned_round(n, level):
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
    assert all(0.95 <= attained_level(n) < 0.97 for n in range(6, 60) if n > 6) and attained_level(1) == 0.0


@given(QUARTERS)
def test_it_is_the_median_of_all_means_of_two(differences):
    pairs = [(a + b) / 2 for i, a in enumerate(differences) for b in differences[i:]]
    found = hodges_lehmann(differences)
    assert found.shift == np.median(pairs)
    assert min(differences) <= found.low <= found.shift <= found.high <= max(differences)


@given(QUARTERS, st.integers(-8, 8))
def test_it_moves_and_mirrors_with_the_data(differences, move):
    found = hodges_lehmann(differences)
    moved = hodges_lehmann([d + move for d in differences])
    assert moved == tuple(value + move for value in found)
    assert hodges_lehmann([-d for d in differences]) == (-found.shift, -found.high, -found.low)


def test_empty_and_invalid_input_is_handled():
    assert np.isnan(hodges_lehmann([])).all()
    with pytest.raises(ValueError, match="finite"):
        hodges_lehmann([np.nan])
