"""From rows to the figures of summary.json."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmdwarp.errors import HmdwarpError
from hmdwarp.metrics import QUALITY, STAGES, aggregate

numbers = st.lists(st.one_of(st.none(), st.floats(0, 1)), min_size=1, max_size=40)


def test_shape_is_that_of_the_contract():
    out = aggregate([])
    assert set(out["quality"]) == set(QUALITY) and set(out["time_ms"]) == set(STAGES)
    assert all(entry == {"mean": None, "p95": None, "interval": None} for entry in out["quality"].values())
    assert all(entry == {"median": None, "p95": None} for entry in out["time_ms"].values())
    assert set(out["measured"].values()) == {0}


@given(numbers, st.randoms())
def test_absent_values_do_not_count_and_order_does_not_matter(values, random):
    rows = [{"flip": v} for v in values] + [{}]
    there = [v for v in values if v is not None]
    out = aggregate(rows)
    random.shuffle(rows)
    assert aggregate(rows) == out
    assert out["measured"]["flip"] == len(there)
    if there:
        assert out["quality"]["flip"]["mean"] == pytest.approx(sum(there) / len(there))
        assert min(there) <= out["quality"]["flip"]["p95"] <= max(there)


@pytest.mark.parametrize("name", QUALITY)
def test_p95_is_the_bad_tail(name):
    values = np.random.default_rng(0).permutation(100) / 100
    entry = aggregate([{name: v} for v in values])["quality"][name]
    is_worse = min if name in ("psnr_db", "ssim") else max
    assert sum(is_worse(value, entry["p95"]) == entry["p95"] for value in values) == 95
    assert is_worse(entry["p95"], entry["mean"]) == entry["p95"] != entry["mean"]


def test_times():
    rows = [{"warp_ms": v, "total_ms": 2 * v, "fill_ms": None} for v in (1.0, 2.0, 100.0)]
    times = aggregate(rows)["time_ms"]
    assert times["warp"]["median"] == 2 and times["total"]["median"] == 4
    # Linear between the 2nd and 3rd of three values.
    assert times["warp"]["p95"] == pytest.approx(2 + 0.9 * 98)
    assert times["fill"] == {"median": None, "p95": None}


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_a_figure_that_is_no_number_is_an_internal_error(bad):
    with pytest.raises(HmdwarpError, match="flip"):
        aggregate([{"flip": bad}])
