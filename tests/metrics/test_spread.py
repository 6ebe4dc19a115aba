"""Intervals of means over instants hold as often as they say, also where neighbours are alike."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from hmdwarp.metrics import LEAST_INSTANTS, at_instants, block_length, difference, excludes_zero, interval_of_mean


def autoregressive(rng: np.random.Generator, count: int, likeness: float) -> np.ndarray:
    """A series of deviation 1 with mean 0, each value `likeness` times the one before and noise."""
    values = np.empty(count)
    values[0] = rng.standard_normal()
    for index in range(1, count):
        values[index] = likeness * values[index - 1] + np.sqrt(1 - likeness**2) * rng.standard_normal()
    return values


@pytest.mark.parametrize(
    ("count", "likeness", "least"),
    # A short series of alike neighbours shows little of their likeness: 85 % where it says 95 %.
    [(6, 0.0, 0.90), (12, 0.0, 0.92), (60, 0.0, 0.92), (60, 0.6, 0.84), (240, 0.9, 0.85), (480, 0.9, 0.88)],
)
def test_intervals_hold_what_is_true_about_as_often_as_they_say(count, likeness, least):
    rng = np.random.default_rng(1)
    trials = 400
    held = 0
    for _ in range(trials):
        low, high = interval_of_mean(autoregressive(rng, count, likeness))
        held += low <= 0 <= high
    assert least <= held / trials <= 0.99


def test_alike_neighbours_make_long_blocks_and_wide_intervals():
    rng = np.random.default_rng(2)
    series = autoregressive(rng, 400, 0.95)
    mixed = rng.permutation(series)
    assert block_length(series) > 4 * block_length(mixed) >= 4 * 400 ** (1 / 3)
    # A head that nods: what is alike a whole period later is not, a quarter of it later.
    assert block_length(np.sin(np.arange(400) * np.pi / 8) + 0.1 * rng.standard_normal(400)) > 20
    (low, high), (low_mixed, high_mixed) = interval_of_mean(series), interval_of_mean(mixed)
    assert high - low > 2 * (high_mixed - low_mixed)


@given(arrays(np.float64, st.integers(LEAST_INSTANTS, 80), elements=st.integers(-5, 5)), st.integers(-3, 3))
def test_it_surrounds_the_mean_moves_with_it_and_mirrors(values, shift):
    low, high = interval_of_mean(values)
    assert low <= values.mean() + 1e-12 and values.mean() - 1e-12 <= high
    assert interval_of_mean(values + shift) == pytest.approx((low + shift, high + shift), abs=1e-9)
    assert interval_of_mean(-values) == pytest.approx((-high, -low), abs=1e-9)


@given(arrays(np.float64, st.integers(LEAST_INSTANTS, 300), elements=st.integers(-5, 5)))
def test_blocks_are_between_the_cube_root_and_a_third(values):
    count = len(values)
    assert min(count ** (1 / 3), count // 3) - 1e-9 <= block_length(values) <= count // 3


def test_too_few_instants_have_no_interval_and_equal_ones_no_width():
    assert interval_of_mean(np.arange(LEAST_INSTANTS - 1)) is None
    assert interval_of_mean(np.full(LEAST_INSTANTS, 0.25)) == (0.25, 0.25)


def rows(values: list[float | None], eyes: int = 2) -> list[dict]:
    return [{"frame": 10 * n, "eye": eye, "flip": value} for n, value in enumerate(values) for eye in range(eyes)]


def test_eyes_of_an_instant_are_one_and_what_was_not_measured_is_left_out():
    assert at_instants([*rows([0.5, None]), {"frame": 0, "eye": 1, "flip": 0.8}], "flip") == {0: pytest.approx(0.6)}


def test_a_difference_is_paired():
    """Two methods that differ by a little at every instant differ for sure, however both vary."""
    hard = np.linspace(0.1, 0.9, 12)
    found = difference(rows(list(hard + 0.01)), rows(list(hard)), "flip")
    assert found["mean"] == pytest.approx(0.01) and excludes_zero(found["interval"])
    assert not excludes_zero(interval_of_mean(hard - hard.mean()))
    assert difference(rows([0.5]), rows([0.4]), "flip")["interval"] is None and not excludes_zero(None)
