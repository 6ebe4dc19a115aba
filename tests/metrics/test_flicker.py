"""Flicker: none for steady error, none for error fixed in the world, and all of what changes."""

import math

import attrs
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import map_coordinates

from hmdwarp.errors import InputError
from hmdwarp.geometry import Hidden, Pose, View, WarpMap
from hmdwarp.metrics import error_image, flicker

from .pictures import FOV, noise, turned

SIZE = (80, 64)
angle = st.floats(-0.25, 0.25)


@settings(max_examples=20)
@given(angle, angle, angle)
def test_constant_error_does_not_flicker_whatever_the_head_does(yaw, pitch, roll):
    error, constant = error_image(noise(1), noise(2)), np.full((SIZE[1], SIZE[0], 3), (0.25, -0.5, 1.0))
    now = turned(yaw, pitch, roll)
    assert flicker(constant, now, constant, turned(0)) == pytest.approx(0, abs=1e-12)
    assert flicker(error, now, error, now) == 0
    assert flicker(error, turned(0, position_m=(5, 1, 2)), error, turned(0)) == 0  # which turns nothing


def test_what_a_lens_hides_does_not_count():
    view = View(Pose(), FOV, hidden=Hidden((((-1, -1), (1, -1), (1, 0), (-1, 0)),), FOV))  # all below the horizon
    error = np.where(view.seen(SIZE)[..., None], 0.5, 9.0) * np.ones(3)
    lower = attrs.evolve(turned(0), hidden=Hidden.of_rows(np.tile((0.0, 0.5), (4, 1)), FOV))  # its upper half
    upside_down = np.where(lower.seen(SIZE)[..., None], 9.0, 0.5) * np.ones(3)
    for hides, seen in ((view, error), (lower, upside_down[::-1])):
        for now, before in ((hides, hides), (hides, turned(0)), (turned(0), hides)):
            assert flicker(seen, now, 0 * seen, before) == pytest.approx(0.5)


def test_only_where_both_exist():
    """Turned by 45 of its 74 degrees, the present picture shares just one half of the previous one
    (0.1 rad short of it).
    """
    a, b = np.zeros((30, 40, 3)), np.zeros((30, 40, 3))
    b[:, :20] = 1
    assert flicker(a, turned(0), b, turned(0)) == 0.5
    assert flicker(a, turned(math.radians(45)), b, turned(0)) == pytest.approx(1)
    assert flicker(a, turned(-math.radians(45)), b, turned(0)) == pytest.approx(0)


def test_views_without_a_common_direction_have_no_flicker():
    error = np.ones((30, 40, 3))
    assert flicker(error, turned(math.pi), error, turned(0)) is None
    assert flicker(error, turned(1.8), error, turned(0)) is None
    with pytest.raises(InputError, match="expected"):
        flicker(np.zeros((3, 4)), turned(0), np.zeros((3, 4)), turned(0))


def test_samples_are_those_of_scipy():
    """All pixels at once by map_coordinates; both are float64, so they differ by sums of 1e-16."""
    error, before = noise(1, (40, 30)) / 255, noise(2, (50, 36)) / 255
    views = turned(0.2, 0.1, 0.3), turned(0)
    x, y = np.meshgrid(np.arange(40) + 0.5, np.arange(30) + 0.5)
    at, _, _ = WarpMap.between(views[0], (40, 30), views[1], (50, 36)).apply(
        np.stack([x, y], axis=-1), np.zeros(x.shape)
    )
    column, row = np.moveaxis(at - 0.5, -1, 0)
    both = (column >= 0) & (column <= 49) & (row >= 0) & (row <= 35)
    sampled = [map_coordinates(before[::-1, :, c], (row[both], column[both]), order=1) for c in range(3)]
    expected = np.abs(error[::-1][both] - np.stack(sampled, axis=-1)).mean()
    assert 0 < both.sum() < both.size
    assert flicker(error, views[0], before, views[1]) == pytest.approx(expected, rel=1e-12)


def test_signed_error():
    shown, truth = np.zeros((1, 1, 3), np.uint8), np.full((1, 1, 3), 255, np.uint8)
    assert (error_image(shown, truth) == -1).all() and (error_image(truth, shown) == 1).all()
    assert np.allclose(error_image(noise(1) / 255, noise(2) / 255), error_image(noise(1), noise(2)), atol=1e-7)
