"""Sharpness: 1 for the truth, less when blurred, not more for noise and jags."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import gaussian_filter, map_coordinates

from hmdwarp.errors import InputError
from hmdwarp.metrics import sharpness

from .pictures import noise, smooth


def textured(seed=0, size=(160, 120)) -> np.ndarray:
    """Detail of all sizes, floats 0..1."""
    rng = np.random.default_rng(seed)
    layers = [gaussian_filter(rng.normal(size=(size[1], size[0], 3)), (s, s, 0)) * s for s in (0.7, 1.5, 4)]
    return np.clip(0.5 + 0.12 * sum(layers), 0, 1)


TRUTH = textured()


def test_the_truth_is_as_sharp_as_itself():
    assert sharpness(TRUTH, TRUTH) == pytest.approx(1, abs=1e-12)
    assert sharpness(noise(1), noise(1)) == pytest.approx(1, abs=1e-12)


def test_blur_lowers_it_and_more_blur_more():
    found = [sharpness(gaussian_filter(TRUTH, (s, s, 0)), TRUTH) for s in (0.3, 0.5, 0.8, 1.5)]
    assert 1 > found[0] > found[1] > found[2] > found[3] > 0


def test_resampling_twice_is_less_sharp_than_once():
    y, x = np.mgrid[:120, :160].astype(float)

    def moved(picture, by):
        return np.stack(
            [map_coordinates(picture[..., c], [y + by, x + by], order=1, mode="nearest") for c in range(3)], axis=-1
        )

    once = sharpness(moved(moved(TRUTH, 1.0), -1.0)[2:-2, 2:-2], TRUTH[2:-2, 2:-2])
    twice = sharpness(moved(moved(TRUTH, 0.4), -0.4)[2:-2, 2:-2], TRUTH[2:-2, 2:-2])
    assert once == pytest.approx(1, abs=1e-9)
    assert 0.2 < twice < 0.9


@settings(max_examples=10)
@given(st.integers(1, 10**6), st.floats(0.01, 0.1))
def test_noise_is_no_sharpness(seed, amount):
    """Added to a blurred picture, it moves the slope by chance alone, which spreads as amount /
    truth detail / sqrt(values).
    """
    blurred = gaussian_filter(TRUTH, (1, 1, 0))
    rng = np.random.default_rng(seed)
    noisy = np.clip(blurred + amount * rng.normal(size=TRUTH.shape), 0, 1)
    detail = TRUTH - gaussian_filter(TRUTH, (0.7, 0.7, 0))
    spread = amount / detail.std() / np.sqrt(TRUTH.size)
    assert abs(sharpness(noisy, TRUTH) - sharpness(blurred, TRUTH)) < 8 * spread
    energy = (noisy - gaussian_filter(noisy, (0.7, 0.7, 0))).std() / detail.std()
    assert (
        energy > 0.3 or amount < 0.03
    )  # what a ratio of energies would have taken for sharpness; seed 0 made the truth


def test_sharpening_raises_it():
    over = np.clip(TRUTH + 0.5 * (TRUTH - gaussian_filter(TRUTH, (1, 1, 0))), 0, 1)
    assert sharpness(over, TRUTH) > 1.1


def test_only_where_it_counts():
    """Black holes do not matter, nor their rims; without the mask they do."""
    shown, where = TRUTH.copy(), np.ones(TRUTH.shape[:2])
    shown[30:60, 40:90], where[30:60, 40:90] = 0, 0
    assert sharpness(shown, TRUTH, where) == pytest.approx(1, abs=1e-12)
    assert sharpness(shown, TRUTH) < 0.95


def test_bytes_and_floats_agree():
    truth = np.rint(TRUTH * 255).astype(np.uint8)
    shown = np.rint(gaussian_filter(TRUTH, (0.6, 0.6, 0)) * 255).astype(np.uint8)
    assert sharpness(shown, truth) == pytest.approx(sharpness(shown / 255, truth / 255), abs=1e-9)


def test_without_detail_there_is_none():
    flat = np.full((20, 20, 3), 0.5)
    assert sharpness(flat, flat) is None
    assert sharpness(noise(1), noise(1), np.zeros((30, 40))) is None


def test_sizes_must_agree():
    with pytest.raises(InputError, match="compare"):
        sharpness(smooth(), smooth((90, 64)))
    with pytest.raises(InputError, match="mask"):
        sharpness(smooth(), smooth(), np.ones((3, 3)))
