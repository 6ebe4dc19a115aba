"""Charts: pooling keeps what matters, and the SVG fits into any page."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from hmdwarp.report import Series, binned

points = st.lists(st.tuples(st.integers(0, 60), st.floats(-1e6, 1e6)), max_size=120)


@given(points, st.integers(1, 50))
def test_pooling_keeps_extremes_and_order(pairs, bins):
    pairs = sorted(pairs)
    time_s = np.array([t for t, _ in pairs], dtype=float)
    value = np.array([v for _, v in pairs], dtype=float)
    pooled = binned(Series("", time_s, value), bins)
    mean, low, high = (one.value for one in pooled)
    assert len(mean) <= max(bins, 0) or len(mean) == len(np.unique(time_s)) <= bins
    if not pairs:
        assert len(mean) == 0
        return
    assert low.min() == value.min() and high.max() == value.max()
    assert (np.diff(pooled[0].time_s) > 0).all()
    slack = 1e-9 * (1 + np.abs(value).max())  # rounding of a mean of at most 120 values
    assert (low <= mean + slack).all() and (mean <= high + slack).all()


def test_both_eyes_of_one_instant_are_one_point():
    pooled = binned(Series("", np.array([0.0, 0.0, 1.0, 1.0]), np.array([1.0, 3.0, 5.0, 5.0])))
    assert [one.value.tolist() for one in pooled] == [[2, 5], [1, 5], [3, 5]]


def test_rows_without_a_value_are_left_out():
    rows = [{"time_s": 2, "flip": 0.5}, {"time_s": 1, "flip": None}, {"time_s": 0, "flip": 0.25}, {"time_s": 3}]
    series = Series.of("a", rows, "flip", 100)
    assert series.time_s.tolist() == [0, 2] and series.value.tolist() == [25, 50]
