"""Charts: pooling keeps what matters, and the SVG fits into any page."""

import re
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmdwarp.report import Series, binned, time_series

from .samples import some_rows

points = st.lists(st.tuples(st.integers(0, 60), st.floats(-1e6, 1e6)), max_size=120)


@given(points, st.integers(1, 50))
def test_pooling_keeps_extremes_and_order(pairs, bins):
    pairs = sorted(pairs)
    time_s = np.array([t for t, _ in pairs], dtype=float)
    value = np.array([v for _, v in pairs], dtype=float)
    band = binned(Series("", time_s, value), bins)
    assert len(band.mean) <= max(bins, 0) or len(band.mean) == len(np.unique(time_s)) <= bins
    if not pairs:
        assert len(band.mean) == 0
        return
    assert band.low.min() == value.min() and band.high.max() == value.max()
    assert (np.diff(band.time_s) > 0).all()
    slack = 1e-9 * (1 + np.abs(value).max())  # rounding of a mean of at most 120 values
    assert (band.low <= band.mean + slack).all() and (band.mean <= band.high + slack).all()


def test_both_eyes_of_one_instant_are_one_point():
    band = binned(Series("", np.array([0.0, 0.0, 1.0, 1.0]), np.array([1.0, 3.0, 5.0, 5.0])))
    assert band.mean.tolist() == [2, 5] and band.low.tolist() == [1, 5] and band.high.tolist() == [3, 5]


def test_rows_without_a_value_are_left_out():
    rows = [{"time_s": 2, "flip": 0.5}, {"time_s": 1, "flip": None}, {"time_s": 0, "flip": 0.25}, {"time_s": 3}]
    series = Series.of("a", rows, "flip", 100)
    assert series.time_s.tolist() == [0, 2] and series.value.tolist() == [25, 50]


def svg(rows=None, *labels):
    rows = some_rows() if rows is None else rows
    return time_series([Series.of(label, rows, "flip") for label in labels or ("forward",)], "unit")


def test_svg_takes_its_colours_from_the_page_and_its_width_too():
    text = svg(None, "forward", "<none> & co")
    root = ElementTree.fromstring(text)
    assert root.tag.endswith("svg") and "viewBox" in root.attrib and not {"width", "height"} & set(root.attrib)
    assert (
        not re.findall(r"#0[0-9]0[0-9]0[0-9]", text)
        and "<style" not in text
        and "http" not in text.replace("http://www.w3.org", "")
    )
    for variable in ("--chart-ink", "--chart-grid", "--series-1", "--series-2"):
        assert f"var({variable})" in text
    words = {"".join(node.itertext()) for node in root.iter("{http://www.w3.org/2000/svg}text")}
    assert {"forward", "<none> & co", "unit", "time in s"} <= words


def test_svg_is_the_same_twice_and_charts_share_no_ids():
    one, other = svg(some_rows(0)), svg(some_rows(1))
    assert one == svg(some_rows(0))
    ids = [set(re.findall(r' id="([^"]+)"', text)) for text in (one, other)]
    assert ids[0] and not ids[0] & ids[1]
    assert set(re.findall(r"#([a-z]\w+)", one)) <= ids[0]  # every reference has its target


def test_a_long_run_makes_no_larger_page():
    short, long = (svg(some_rows(seconds=s, rate=90, every=1)) for s in (20, 120))
    assert len(long) < 1.2 * len(short)


@pytest.mark.parametrize("count", [0, 1, 2])
def test_few_points_or_none(count):
    text = svg([{"time_s": t, "flip": 0.1} for t in range(count)])
    assert ("not measured" in text) == (count == 0)
    assert ("<use" in text) == (count > 0)  # dots


def test_constant_zero_is_drawn_on_an_axis_from_zero():
    svg([{"time_s": t, "flip": 0.0} for t in range(30)])
