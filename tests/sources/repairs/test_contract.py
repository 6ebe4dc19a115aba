"""What every repair keeps to, whatever the picture."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hmdwarp.errors import InputError, UnknownNameError
from hmdwarp.sources.repairs import parse_repairs, repairs

from .pictures import same, two_surfaces

CHAINS = [*repairs.names(), "edges+complete", "complete+edges", "complete:least=0.5"]
SIZES = [(1, 1), (2, 1), (1, 9), (7, 5), (33, 17), (40, 64)]


@st.composite
def frames(draw: st.DrawFn) -> tuple[np.ndarray, np.ndarray]:
    """Any colour; depth in steps and at random, with infinity, huge values and gaps, or none."""
    wide, high = draw(st.sampled_from(SIZES))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    colour = rng.random((high, wide, 3)).astype(np.float32)
    if draw(st.booleans()):
        colour = np.zeros_like(colour)
    kinds = np.array([0.0, 0.2, 0.21, 1.0, 5.0, 1e30, np.nan], np.float32)
    inverse = kinds[rng.integers(0, len(kinds), (high, wide))]
    inverse[rng.random((high, wide)) < draw(st.sampled_from([0, 0.3, 0.95, 1]))] = np.nan
    return colour, inverse


@pytest.mark.parametrize("text", CHAINS)
@given(frame=frames())
@settings(max_examples=60)
def test_no_depth_is_invented_outside_what_was_measured(text, frame):
    """A guess is a weighted mean of measured depths: within their range, but for rounding.

    Eight products and sums in float32 round by at most 16 * 2^-24 of the largest. Read-only arrays
    are taken and stay as they are; twice gives the same bits; without depth there is none.
    """
    colour, inverse = frame
    before, known = inverse.copy(), inverse[~np.isnan(inverse)]
    for array in frame:
        array.setflags(write=False)
    found, again = (parse_repairs(text).run(colour, inverse) for _ in range(2))
    depth, confidence = found.inverse_depth, found.confidence
    assert depth.shape == confidence.shape == inverse.shape and depth.dtype == confidence.dtype == np.float32
    assert ((confidence >= 0) & (confidence <= 1)).all() and np.array_equal(confidence == 0, np.isnan(depth))
    assert same(inverse, before) and same(depth, again.inverse_depth) and same(confidence, again.confidence)
    assert len(known) or np.isnan(depth).all()
    depth = depth[~np.isnan(depth)]
    if len(depth):
        slack = 16 * 2.0**-24 * known.max()
        assert depth.min() >= max(known.min() - slack, 0) and depth.max() <= known.max() + slack


def plane(slope: float) -> tuple[np.ndarray, np.ndarray]:
    rows, columns = np.indices((60, 80))
    colour = np.random.default_rng(1).random((60, 80, 3)).astype(np.float32)
    return colour, (0.5 + slope * (rows + columns)).astype(np.float32)


@pytest.mark.parametrize("text", CHAINS)
@pytest.mark.parametrize("slope", [0.0, 0.0005, 0.004, None])
def test_perfect_depth_stays_as_it_is(text, slope):
    """Bit for bit: nothing is missing, and 0.004 /m a pixel is no jump from 0.5 /m on.

    Nor between two surfaces, which meet their colours where they are.
    """
    colour, inverse = two_surfaces() if slope is None else plane(slope)
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


@pytest.mark.parametrize(
    ("text", "error", "message"),
    [
        ("complete+none", InputError, "leave it out"),
        ("complete:lest=1", InputError, "its settings and their defaults: tolerance"),
        ("complete:least=2", InputError, "least is 2: expected 0 to 1"),
        ("complete:reach=0", InputError, "expected more than 0"),
        ("complete:tolerance=-1", InputError, "expected 0 or more"),
        ("edges:most=100", InputError, "expected 0 to 64 pixels"),
        ("edges:evidence=-1", InputError, "evidence is -1"),
        ("complet", UnknownNameError, "did you mean 'complete'"),
        (None, InputError, "repair is None: expected a name"),
    ],
)
def test_texts_that_cannot_be_meant_are_refused(text, error, message):
    with pytest.raises(error, match=message):
        parse_repairs(text)
