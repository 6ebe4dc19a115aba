"""Flicker: none for steady error, none for error fixed in the world, and all of what changes."""

from __future__ import annotations

import math
from contextlib import closing

import attrs
import numpy as np
import pytest

from hmdwarp.geometry import Hidden, Pose, View
from hmdwarp.metrics import Compared, PairPass, error_image

from .pictures import FOV, flicker, noise, turned

SIZE = (66, 37)
BELOW = Hidden((((-1, -1), (1, -1), (1, 0), (-1, 0)),), FOV)  # all below the horizon
UPPER = Hidden.of_rows(np.tile((0.0, 0.5), (4, 1)), FOV)


@pytest.fixture
def found(gpu):
    """What a pass finds of two pairs of pictures."""
    with closing(PairPass(gpu, SIZE, 20.0)) as measuring:
        yield measuring.flicker


def grey(error: np.ndarray, view: View) -> Compared:
    """Pictures with that error (h, w), in levels, all over a grey."""
    truth = np.full((*SIZE[::-1], 3), 100, np.uint8)
    return Compared((truth + error[..., None]).astype(np.uint8), truth, view)


def even(levels: int, view: View) -> Compared:
    return grey(np.full(SIZE[::-1], levels), view)


@pytest.mark.parametrize("head", [(0.2, 0.1, -0.2), (-0.25, 0.0, 0.0), (0.0, 0.0, 0.25)])
def test_constant_error_does_not_flicker_whatever_the_head_does(found, head):
    assert found(even(50, turned(*head)), even(50, turned(0))) == pytest.approx(0, abs=1e-6)
    now = Compared(noise(1, SIZE), noise(2, SIZE), turned(*head))
    assert found(now, now) == pytest.approx(0, abs=2e-4)
    beside = attrs.evolve(now, view=turned(*head, position_m=(5, 1, 2)))  # which turns nothing
    assert found(beside, now) == pytest.approx(0, abs=2e-4)


@pytest.mark.parametrize("hidden", [BELOW, UPPER])
def test_what_a_lens_hides_does_not_count(found, hidden):
    view = View(Pose(), FOV, hidden=hidden)
    for now, before in ((view, view), (view, turned(0)), (turned(0), view)):
        error = np.where(view.seen(SIZE), 51, 150)
        assert found(grey(error, now), even(0, before)) == pytest.approx(0.2)


def test_only_where_both_exist(found):
    """Turned by 45 of its 74 degrees, the present picture shares just one half of the previous one
    (0.1 rad short of it).
    """
    half = np.where(np.arange(SIZE[0]) < SIZE[0] // 2, 51, 0) * np.ones((SIZE[1], 1), int)
    assert found(even(0, turned(0)), grey(half, turned(0))) == pytest.approx(0.1)
    assert found(even(0, turned(math.radians(45))), grey(half, turned(0))) == pytest.approx(0.2)
    assert found(even(0, turned(-math.radians(45))), grey(half, turned(0))) == pytest.approx(0, abs=1e-6)
    for angle in (math.pi, 1.8):  # no common direction
        assert found(even(9, turned(angle)), even(9, turned(0))) is None


@pytest.mark.parametrize("turn_rad", [0.0, 0.005, 0.07, 0.4])
@pytest.mark.parametrize("hidden", [None, BELOW, UPPER])
def test_samples_are_those_of_float64(found, turn_rad, hidden):
    """Places of float32 are off by a few 2**-17 pixels, errors by at most 2 from pixel to pixel.

    Beside a border of what is hidden one pixel of a row of 37 may count or not.
    """
    pairs = [[noise(2 * k + i, SIZE) for i in range(2)] for k in range(2)]
    now, before = (
        Compared(*pair, attrs.evolve(turned(angle), hidden=hidden))
        for pair, angle in zip(pairs, (0.0, turn_rad), strict=True)
    )
    for earlier in (before, Compared(before.truth, before.shown, before.view), before):
        off = 2e-4 if hidden is None else 2e-3
        assert found(now, earlier) == pytest.approx(flicker(now, earlier), abs=off)


def test_signed_error():
    shown, truth = np.zeros((1, 1, 3), np.uint8), np.full((1, 1, 3), 255, np.uint8)
    assert (error_image(shown, truth) == -1).all() and (error_image(truth, shown) == 1).all()
    assert np.allclose(error_image(noise(1) / 255, noise(2) / 255), error_image(noise(1), noise(2)), atol=1e-7)
