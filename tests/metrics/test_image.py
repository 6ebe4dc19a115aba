"""PSNR, SSIM and FLIP.

Known answers, and the mistakes that are easy to make.
"""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from properties import ONE_FIXTURE_FOR_ALL

import hmdwarp
from hmdwarp.errors import InputError
from hmdwarp.metrics import Compared, PairPass, QualityJob, flip, measure, psnr, ssim

from .pictures import noise, smooth, turned

PPD = 22.0
colours = st.tuples(*[st.integers(0, 255)] * 3)


def flat(colour, size=(8, 6)) -> np.ndarray:
    return np.full((size[1], size[0], 3), colour, np.uint8)


def flip_of_flat_colours(reference, test) -> float:
    """FLIP of two pictures of one colour each, from the paper: no filter changes them.

    Source: Andersson et al. 2020, sections 4.1-4.3 (qc = 0.7, pc = 0.4, pt = 0.95) with the D65
    white of linear RGB (1, 1, 1).
    """
    xyz_from_rgb = np.array(
        [
            [10135552 / 24577794, 8788810 / 24577794, 4435075 / 24577794],
            [2613072 / 12288897, 8788810 / 12288897, 887015 / 12288897],
            [1425312 / 73733382, 8788810 / 73733382, 70074185 / 73733382],
        ]
    )
    white = xyz_from_rgb.sum(axis=1)

    def hunt_lab(linear):
        ratio = xyz_from_rgb @ linear / white
        delta = 6 / 29
        f = np.where(ratio > delta**3, np.cbrt(ratio), ratio / (3 * delta**2) + 4 / 29)
        lightness = 116 * f[1] - 16
        return np.array([lightness, 0.01 * lightness * 500 * (f[0] - f[1]), 0.01 * lightness * 200 * (f[1] - f[2])])

    def hyab(a, b):
        return abs(a[0] - b[0]) + math.hypot(a[1] - b[1], a[2] - b[2])

    def linear(colour):
        c = np.asarray(colour) / 255
        return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)

    largest = hyab(hunt_lab(np.array([0, 1.0, 0])), hunt_lab(np.array([0, 0, 1.0]))) ** 0.7
    error = hyab(hunt_lab(linear(reference)), hunt_lab(linear(test))) ** 0.7
    knee = 0.4 * largest
    return error * 0.95 / knee if error < knee else 0.95 + (error - knee) / (largest - knee) * 0.05


def flip_of(gpu, shown, truth, pixels_per_degree: float) -> tuple[float, np.ndarray]:
    """The mean FLIP error and its map."""
    measuring = PairPass(gpu, truth.shape[1::-1], pixels_per_degree)
    found = measuring.run(shown, truth)
    measuring.close()
    return measure(QualityJob(Compared(shown, truth, turned(0)), alike=found)).values["flip"], found.flip_map


@settings(max_examples=50, suppress_health_check=ONE_FIXTURE_FOR_ALL)
@given(colours, colours)
def test_flip_of_flat_colours_is_that_of_the_paper(gpu, reference, test):
    """Swapped channels, or linear values taken for sRGB, change the answer of almost every pair.

    At 5 pixels per degree the kernels are a few pixels and sum to 1 within float32 (at 22 only
    within 1e-4); the colours then carry 1e-7, which a lightness of 116 and 500 x differences turn
    into 1e-5 at most.
    """
    assert flip_of(gpu, flat(test), flat(reference), 5)[0] == pytest.approx(
        flip_of_flat_colours(reference, test), abs=1e-5
    )


def test_flip_uses_the_pixels_per_degree():
    """The same angles at twice the resolution look the same.

    A map that ignored ppd, or took its default of 67, would not.
    """
    coarse = [smooth((48, 40), phase) for phase in (0.0, 0.35)]
    coarse[1][12:20, 20:23] = 255
    fine = [p.repeat(2, axis=0).repeat(2, axis=1) for p in coarse]
    at_coarse = flip(coarse[1], coarse[0], PPD)
    same_angles = flip(fine[1], fine[0], 2 * PPD)
    default = flip(coarse[1], coarse[0], 67)
    # What is left is the filters' own sampling, which ends at whole pixels.
    assert same_angles == pytest.approx(at_coarse, rel=0.05)
    assert abs(default - at_coarse) > 3 * abs(same_angles - at_coarse)


def test_flip_map_belongs_to_its_picture(gpu):
    truth = smooth()
    shown = truth.copy()
    shown[10:14, 70:76] = (255, 0, 0)
    mean, error = flip_of(gpu, shown, truth, PPD)
    assert error.shape == truth.shape[:2] and error.min() >= 0 and error.max() <= 1
    row, column = np.unravel_index(error.argmax(), error.shape)
    assert 10 <= row < 14 and 70 <= column < 76
    assert mean == pytest.approx(error.mean(dtype=np.float64))


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


def test_holes_at_the_border_count_for_every_figure():
    truth = smooth()
    shown = truth.copy()
    shown[:3] = 0  # within the five pixels that scikit-image leaves out of its own mean
    assert psnr(shown, truth) < 25
    assert ssim(shown, truth) < 0.97 and flip(shown, truth) > 0.01


def test_ssim_is_the_formula_of_the_paper():
    """Every window by hand.

    Eq. 13 with a Gaussian of sigma 1.5 cut at 11x11, the border mirrored, the mean over all pixels.
    """
    shown, truth = noise(5, (14, 13)), noise(6, (14, 13))
    k = np.exp(-((np.arange(11) - 5) ** 2) / (2 * 1.5**2))
    weights = np.outer(k, k) / np.outer(k, k).sum()

    def mean_of(image):
        padded = np.pad(image, ((5, 5), (5, 5), (0, 0)), mode="symmetric")
        return np.einsum(
            "ijckl,kl->ijc", np.lib.stride_tricks.sliding_window_view(padded, (11, 11), axis=(0, 1)), weights
        )

    x, y = shown.astype(float), truth.astype(float)
    mx, my = mean_of(x), mean_of(y)
    vx, vy, vxy = mean_of(x * x) - mx**2, mean_of(y * y) - my**2, mean_of(x * y) - mx * my
    c1, c2 = (0.01 * 255) ** 2, (0.03 * 255) ** 2
    by_hand = ((2 * mx * my + c1) * (2 * vxy + c2) / ((mx**2 + my**2 + c1) * (vx + vy + c2))).mean()
    assert ssim(shown, truth) == pytest.approx(by_hand, abs=5e-5)  # as in test_pair_pass


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
