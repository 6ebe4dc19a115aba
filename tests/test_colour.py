"""sRGB and linear light: the standard's anchors, round trips, and bytes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmdwarp.base import linear_from_srgb, picture_from_linear, srgb8_from_linear, srgb_from_linear

unit = st.floats(0, 1)


@given(unit)
def test_round_trip(value):
    # The standard's two branches miss each other by 4e-8 at the joint; elsewhere only float64
    # rounding is left.
    assert linear_from_srgb(srgb_from_linear(value)) == pytest.approx(value, abs=1e-7)


@given(unit, unit)
def test_order_is_kept(a, b):
    low, high = sorted((a, b))
    assert srgb_from_linear(low) <= srgb_from_linear(high) + 4e-8  # the joint of the two branches
    assert linear_from_srgb(low) <= linear_from_srgb(high) + 4e-8


def test_every_byte_survives():
    bytes_ = np.arange(256, dtype=np.uint8)
    assert np.array_equal(srgb8_from_linear(linear_from_srgb(bytes_)), bytes_)


def test_known_values():
    # IEC 61966-2-1: 18 % grey encodes to 0.4613561, mid grey 0.5 decodes to 0.2140411 (both from
    # the formula, by hand).
    assert srgb_from_linear(0.18) == pytest.approx(0.4613561, abs=1e-7)
    assert linear_from_srgb(0.5) == pytest.approx(0.2140411, abs=1e-7)
    assert srgb_from_linear([0.0, 1.0]).tolist() == [0.0, 1.0]


def test_half_floats_give_the_same_bytes_as_the_formula():
    halves = np.arange(65536, dtype=np.uint16).view(np.float16)
    with np.errstate(invalid="ignore"):
        expected = srgb8_from_linear(halves.astype(np.float64))
    assert np.array_equal(srgb8_from_linear(halves), expected)


@pytest.mark.parametrize("dtype", [np.float16, np.float32, np.float64])
def test_values_beyond_a_byte_are_clamped(dtype):
    assert srgb8_from_linear(np.array([np.nan, -np.inf, -1, 0, 2, np.inf], dtype)).tolist() == [0, 0, 0, 0, 255, 255]


def test_holes_are_black():
    image = np.full((2, 2, 4), 0.5, np.float16)
    image[0, 0, 3] = 0
    picture = picture_from_linear(image)
    assert picture[0, 0].tolist() == [0, 0, 0]
    assert (picture[image[..., 3] > 0] == 188).all()  # 255 * srgb(0.5) = 187.5
