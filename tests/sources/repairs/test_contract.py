"""What every repair keeps to, whatever the picture."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hmdwarp.errors import InputError, UnknownNameError
from hmdwarp.sources.repairs import MeasuredDepth, parse_repairs, repairs

from .pictures import same, two_surfaces

CHAINS = [*repairs.names(), "edges+complete", "complete+edges", "complete:least=0.5"]
SIZES = [(1, 1), (2, 1), (1, 9), (7, 5), (33, 17), (40, 64)]


def check(depth: MeasuredDepth, shape: tuple[int, int]) -> None:
    inverse, confidence = depth.inverse_depth, depth.confidence
    assert inverse.shape == confidence.shape == shape
    assert inverse.dtype == confidence.dtype == np.float32
    assert not np.isinf(inverse).any() and not (inverse < 0).any()
    assert ((confidence >= 0) & (confidence <= 1)).all()
    assert np.array_equal(confidence == 0, np.isnan(inverse))


@st.composite
def frames(draw: st.DrawFn) -> tuple[np.ndarray, np.ndarray]:
    """Any colour; depth in steps and at random, with infinity, huge values and gaps."""
    wide, high = draw(st.sampled_from(SIZES))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    colour = rng.random((high, wide, 3)).astype(np.float32)
    if draw(st.booleans()):
        colour = np.zeros_like(colour)
    kinds = np.array([0.0, 0.2, 0.21, 1.0, 5.0, 1e30, np.nan], np.float32)
    inverse = kinds[rng.integers(0, len(kinds), (high, wide))]
    inverse[rng.random((high, wide)) < draw(st.sampled_from([0, 0.3, 0.95]))] = np.nan
    return colour, inverse


@pytest.mark.parametrize("text", CHAINS)
@given(frame=frames())
@settings(max_examples=40)
def test_shape_range_and_holes_are_right(text, frame):
    """Read-only arrays are taken and stay as they are; twice gives the same bits."""
    colour, inverse = frame
    before = inverse.copy()
    for array in frame:
        array.setflags(write=False)
    found = parse_repairs(text).run(colour, inverse)
    check(found, inverse.shape)
    assert same(inverse, before)
    again = parse_repairs(text).run(colour, inverse)
    assert same(found.inverse_depth, again.inverse_depth) and same(found.confidence, again.confidence)


@pytest.mark.parametrize("text", CHAINS)
@given(frame=frames())
@settings(max_examples=40)
def test_no_depth_is_invented_outside_what_was_measured(text, frame):
    """A guess is a weighted mean of measured depths: within their range, but for rounding.

    Eight products and sums in float32 round by at most 16 * 2^-24 of the largest.
    """
    colour, inverse = frame
    known = inverse[~np.isnan(inverse)]
    found = parse_repairs(text).run(colour, inverse).inverse_depth
    found = found[~np.isnan(found)]
    if len(found):
        slack = 16 * 2.0**-24 * known.max()
        assert found.min() >= known.min() - slack and found.max() <= known.max() + slack


@pytest.mark.parametrize("text", CHAINS)
@pytest.mark.parametrize("size", SIZES)
def test_a_frame_without_depth_stays_one(text, size):
    colour = np.ones((size[1], size[0], 3), np.float32)
    found = parse_repairs(text).run(colour, np.full(size[::-1], np.nan))
    check(found, size[::-1])
    assert np.isnan(found.inverse_depth).all()


@pytest.mark.parametrize("text", CHAINS)
@pytest.mark.parametrize("slope", [0.0, 0.0005, 0.004])
def test_perfect_depth_without_silhouettes_stays_as_it_is(text, slope):
    """Bit for bit: nothing is missing, and 0.004 /m a pixel is no jump from 0.5 /m on."""
    rng = np.random.default_rng(1)
    rows, columns = np.indices((60, 80))
    inverse = (0.5 + slope * (rows + columns)).astype(np.float32)
    found = parse_repairs(text).run(rng.random((60, 80, 3)).astype(np.float32), inverse)
    assert same(found.inverse_depth, inverse) and (found.confidence == 1).all()


@pytest.mark.parametrize("text", CHAINS)
def test_perfect_depth_with_silhouettes_stays_as_it_is(text):
    """Two surfaces only: nothing lies between them, and they meet their colours where they are."""
    colour, inverse = two_surfaces()
    found = parse_repairs(text).run(colour, inverse)
    assert same(found.inverse_depth, inverse) and (found.confidence == 1).all()


@pytest.mark.parametrize("name", repairs.names())
def test_it_says_what_it_is_and_what_it_needs(name):
    entry = repairs.get(name)
    assert entry.summary and entry.needs and entry.source
    assert all(field.default is not attrs.NOTHING for field in attrs.fields(entry.Settings))
    assert str(parse_repairs(name).text) == name


def test_chains_are_read_as_fills_are():
    assert parse_repairs("none").steps == ()
    assert parse_repairs("edges:most=3 + complete:least=0.50").text == "edges:most=3+complete:least=0.5"
    for text, message in (
        ("complete+none", "leave it out"),
        ("complete:lest=1", "its settings and their defaults: tolerance"),
        ("complete:least=2", "least is 2: expected 0 to 1"),
        ("complete:reach=0", "expected more than 0"),
        ("complete:tolerance=-1", "expected 0 or more"),
        ("edges:most=100", "expected 0 to 64 pixels"),
        ("edges:evidence=-1", "evidence is -1"),
    ):
        with pytest.raises(InputError, match=message):
            parse_repairs(text)
    with pytest.raises(UnknownNameError, match="did you mean 'complete'"):
        parse_repairs("complet")
    with pytest.raises(InputError, match="repair is None: expected a name"):
        parse_repairs(None)
