"""The lens polynomial and its inverse, over the panel and beyond it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from reference.lens import lens_from_tangent

from hmdwarp.errors import InputError
from hmdwarp.headsets import MAX_COEFFICIENTS, RadialLens, headset_names, load_headset

WITH_LENS = [name for name in headset_names() if load_headset(name).lens]
COLOURS = ("red", "green", "blue")


def lens(*green: float, reach: float = 1.5, per_unit: float = 0.9) -> RadialLens:
    return RadialLens((0.005, 0.0), 0.04, per_unit, {"red": (1.0,), "green": green, "blue": (1.0, 0.1)}, reach)


@pytest.mark.parametrize("name", WITH_LENS)
@pytest.mark.parametrize("colour", COLOURS)
@pytest.mark.parametrize("eye", [0, 1])
def test_there_and_back_over_the_panel(name, colour, eye):
    headset = load_headset(name)
    x, y = np.meshgrid(np.linspace(0, 1, 23), np.linspace(0, 1, 29))  # with the four corners
    scale, offset = headset.lens_from_panel(eye, (1, 1))
    on_lens = np.stack([x, y], axis=-1) * scale + offset
    again = lens_from_tangent(headset.lens, headset.lens.tangents(colour, on_lens), colour)
    assert np.abs(again - on_lens).max() <= 1e-9


# Growing polynomials: all coefficients positive, the first one well so.
GROWING = st.builds(
    lambda first, rest: (first, *rest), st.floats(0.3, 2), st.lists(st.floats(0, 0.5), max_size=MAX_COEFFICIENTS - 1)
)


@given(GROWING, st.floats(-1, 1), st.floats(-1, 1))
def test_the_formula(coefficients, x, y):
    r2 = x * x + y * y
    wanted = np.array([x, y]) * 0.9 * sum(k * r2**i for i, k in enumerate(coefficients))
    assert lens(*coefficients).tangents("green", np.array([x, y])) == pytest.approx(wanted, rel=1e-12, abs=1e-300)


# r + k r^3 turns where 1 + 3 k r^2 = 0.


def test_a_fold_inside_the_panel_is_refused_with_its_radius():
    """r + k r^3 turns where 1 + 3 k r^2 = 0, and 1 - 3 r^2 + 2 r^4 at 0.7071 and again at 1."""
    for k in (-0.2, -0.5, -1.0, -5.0):
        fold = math.sqrt(-1 / (3 * k))
        with pytest.raises(InputError, match=f"green folds back at r = {fold:.4g}, inside the panel"):
            lens(1.0, k, reach=fold * 1.01)
        assert lens(1.0, k, reach=fold * 0.99).folds_at("green") is None
    with pytest.raises(InputError, match=r"r = 0\.7071,"):
        lens(1.0, -1.0, 0.4, reach=1.5)
    assert lens(1.0, -0.9, 0.4, reach=1.5).folds_at("green") is None
    for coefficients in ((0.0, 1.0), (-1.0,), (0.0,), (-1e-12, 5.0)):
        with pytest.raises(InputError, match="folds back at r = 0,"):
            lens(*coefficients)


@given(st.lists(st.floats(-1, 1), min_size=1, max_size=5))
@example([1e-13, -1.0, 1e-13])  # a small root beside a large one
@example([1.0, -1.0, 5e-301])
def test_any_polynomial_is_refused_or_grows(coefficients):
    try:
        made = lens(*coefficients)
    except InputError:
        return
    r = np.linspace(0, made.reach, 500)
    tangents = made.tangents("green", np.stack([r, np.zeros_like(r)], axis=-1))[:, 0]
    # A double root of the slope is a point of rest, not a turn. The slope may be 1e-12 of its terms
    # below 0 there (they are below 9 * 1.5^8 = 231 each), over a step of 0.003.
    assert np.diff(tangents).min() >= -1e-12
