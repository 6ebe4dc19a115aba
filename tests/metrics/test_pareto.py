"""The Pareto front.

Nobody on it is beaten, everybody off it is, and ties stay together in their order.
"""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmdwarp.errors import HmdwarpError
from hmdwarp.metrics import error_and_time, pareto

# Few different values, so that ties in one cost and in both are frequent; and any float, infinities
# included.
COST = st.one_of(st.integers(0, 4).map(float), st.floats(allow_nan=False))
ROWS = st.lists(st.tuples(COST, COST), max_size=40)


def costs(row):
    return row[:2]


def beats(one, other):
    return one[0] <= other[0] and one[1] <= other[1] and one != other


def numbered(pairs):
    return [(*pair, number) for number, pair in enumerate(pairs)]


@given(ROWS, st.lists(st.tuples(st.one_of(st.none(), COST), st.none()), max_size=5))
def test_no_row_beats_one_of_the_front_and_unmeasured_ones_take_no_part(pairs, blanks):
    """Against the definition itself, every pair compared."""
    rows = numbered(pairs)
    front = [row for row in rows if not any(beats(other[:2], row[:2]) for other in rows)]
    assert pareto([*numbered(blanks), *rows], costs) == front


def test_costs_of_a_row_of_the_bench():
    row = {
        "quality": {"flip": {"mean": 0.1}, "psnr_db": {"mean": 30.0}, "ssim": {"mean": None}},
        "time_ms": {"total": {"median": 7.0}},
    }
    assert error_and_time(row) == (0.1, 7.0)
    assert error_and_time(row, "psnr_db") == (-30.0, 7.0)
    assert error_and_time(row, "ssim") == (None, 7.0)
    assert pareto([row]) == [row]
    with pytest.raises(HmdwarpError, match="not a number"):
        pareto([(1.0, math.nan)], costs)
