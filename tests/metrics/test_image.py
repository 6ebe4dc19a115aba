"""PSNR, SSIM and FLIP. Known answers, and the mistakes that are easy to make."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import hmdwarp
from hmdwarp.base import InputError
from hmdwarp.metrics import flip, psnr, ssim

from . import pictures
from .pictures import noise, smooth


def flat(colour, size=(8, 6)) -> np.ndarray:
    return np.full((size[1], size[0], 3), colour, np.uint8)


def test_flip_and_ssim_are_those_of_the_libraries_at_the_pixels_per_degree_that_are_said():
    """Bounds as in test_pair_pass; holes at the border, where libraries leave some out, count."""
    truth, shown = smooth(), smooth(phase=0.35)
    shown[:3] = 0
    for pixels_per_degree in (5.0, 22.0):
        wanted, _ = pictures.flip(shown, truth, pixels_per_degree)
        assert flip(shown, truth, pixels_per_degree) == pytest.approx(wanted, abs=1e-5)
    assert ssim(shown, truth) == pytest.approx(pictures.ssim(shown, truth), abs=5e-5)


@pytest.mark.parametrize("size", [(1, 1), (3, 7), (40, 30)])
def test_identical_pictures(size):
    picture = noise(1, size)
    assert (psnr(picture, picture), ssim(picture, picture), flip(picture, picture)) == (100, 1, 0)


@given(st.integers(0, 255), st.integers(0, 255))
def test_psnr_of_a_constant_difference(a, b):
    expected = 100 if a == b else 20 * math.log10(255 / abs(a - b))
    assert psnr(flat((a, a, a)), flat((b, b, b))) == pytest.approx(expected)


def test_psnr_never_passes_its_cap():
    picture = flat((9, 9, 9), (400, 400))
    almost = picture.copy()
    almost[0, 0, 0] = 10  # 20 log10(255) + 10 log10(480000) = 104.9 dB
    assert psnr(almost, picture) == 100


def test_floats_and_bytes_agree():
    shown, truth = smooth(), smooth(phase=0.2)
    for figure in (psnr, ssim, flip):
        assert figure(shown / 255, truth / 255) == pytest.approx(figure(shown, truth), rel=1e-5)
    assert set(dir(hmdwarp.metrics)) == {"psnr", "ssim", "flip"}


@pytest.mark.parametrize(
    "shown, truth, told",
    [
        (noise(1), noise(1, (40, 31)), "(31, 40, 3)"),
        (noise(1)[..., 0], noise(1)[..., 0], "(30, 40)"),
        (noise(1), noise(1) / 255, "float64"),
        (noise(1).astype(float), noise(1).astype(float), "0..1"),
        (noise(1) / 255, np.full((30, 40, 3), np.nan), "NaN"),
        (np.zeros((0, 4, 3), np.uint8), np.zeros((0, 4, 3), np.uint8), "(0, 4, 3)"),
    ],
)
def test_pictures_that_cannot_be_compared(shown, truth, told):
    with pytest.raises(InputError) as caught:
        psnr(shown, truth)
    assert told in str(caught.value)
