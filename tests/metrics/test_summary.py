"""From rows to the figures of summary.json: means, intervals, Pareto front, worst pictures."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from hmdwarp.base import HmdwarpError
from hmdwarp.metrics import (
    LEAST_INSTANTS,
    QUALITY,
    STAGES,
    Kept,
    QualityResult,
    aggregate,
    at_instants,
    block_length,
    difference,
    error_and_time,
    excludes_zero,
    interval_of_mean,
    keep_worst,
    pareto,
)  # fmt: skip

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


# --- intervals of means over instants -------------------------------------------------------------


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


def rows_of(values: list[float | None], eyes: int = 2) -> list[dict]:
    return [{"frame": 10 * n, "eye": eye, "flip": value} for n, value in enumerate(values) for eye in range(eyes)]


def test_eyes_of_an_instant_are_one_and_what_was_not_measured_is_left_out():
    assert at_instants([*rows_of([0.5, None]), {"frame": 0, "eye": 1, "flip": 0.8}], "flip") == {0: pytest.approx(0.6)}


def test_a_difference_is_paired():
    """Two methods that differ by a little at every instant differ for sure, however both vary."""
    hard = np.linspace(0.1, 0.9, 12)
    found = difference(rows_of(list(hard + 0.01)), rows_of(list(hard)), "flip")
    assert found["mean"] == pytest.approx(0.01) and excludes_zero(found["interval"])
    assert not excludes_zero(interval_of_mean(hard - hard.mean()))
    assert difference(rows_of([0.5]), rows_of([0.4]), "flip")["interval"] is None and not excludes_zero(None)


# --- the Pareto front -----------------------------------------------------------------------------

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


# --- the worst pictures ---------------------------------------------------------------------------


def kept(key: int, flip: float) -> Kept:
    return Kept(key, None, QualityResult({"flip": flip}))


flips = st.lists(st.sampled_from([0.0, 0.1, 0.2, 0.3, 0.5, 0.9]), max_size=30)


@given(flips, st.integers(0, 5), st.integers(1, 7), st.randoms())
def test_any_order_keeps_the_same(values, count, per_bucket, random):
    offered = [kept(key, flip) for key, flip in enumerate(values)]
    random.shuffle(offered)
    found = {}
    for item in offered:
        keep_worst(found, item, item.key // per_bucket, count)
    # By sorting everything at once: the worst of each bucket, then the worst of those.
    best = {}
    for item in sorted(offered, key=lambda k: k.rank):
        best[item.key // per_bucket] = item
    expected = sorted(best.values(), key=lambda k: k.rank, reverse=True)[:count]
    assert {k.key for k in found.values()} == {k.key for k in expected}
