"""FLIP, SSIM and flicker on the GPU against their judges: libraries and float64."""

from __future__ import annotations

import numpy as np
import pytest

from hmdwarp.errors import InputError
from hmdwarp.metrics import Compared, PairPass, error_image, flicker

from .pictures import flip, noise, ssim, turned


def pictures(size: tuple[int, int], seed: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Noise, shifted edges, flat tints, black holes, and the ends of the range."""
    wide, high = size
    rng = np.random.default_rng(seed)
    noise = rng.integers(0, 256, (high, wide, 3), np.uint8)
    steps = np.where((np.indices((high, wide)).sum(axis=0) // 5 % 2)[..., None], noise[:1, :1], noise[-1:, -1:])
    holed = steps.copy()
    holed[high // 3 :, wide // 2 :] = 0
    black, green = np.zeros_like(noise), np.broadcast_to(np.uint8([0, 255, 0]), noise.shape)
    blue = np.broadcast_to(np.uint8([0, 0, 255]), noise.shape)
    return [(noise, noise[::-1]), (np.roll(steps, 1, axis=1), steps), (holed, steps), (black, ~black), (green, blue)]


@pytest.mark.parametrize("size", [(1, 1), (7, 3), (66, 37), (130, 90)])
@pytest.mark.parametrize("pixels_per_degree", [0.7, 2.0, 11.3, 20.0, 67.0])
def test_figures_are_those_of_the_libraries(size, pixels_per_degree, gpu):
    """FLIP's maps within 1e-3 and means within 1e-5: the same formulas in float32.

    SSIM takes squares of up to 2**14 from each other, rounded by 2**-10 each, over 58.5 (its C2):
    5e-5 for three of them, where that is all there is.
    """
    measuring = PairPass(gpu, size, pixels_per_degree)
    for shown, truth in pictures(size, seed=size[0]):
        mean, wanted = flip(shown, truth, pixels_per_degree)
        alike = measuring.run(shown, truth)
        found = alike.flip_map
        assert found == pytest.approx(wanted, abs=1e-3)
        assert found.mean(dtype=np.float64) == pytest.approx(mean, abs=1e-5)
        assert alike.ssim == pytest.approx(ssim(shown, truth), abs=5e-5)
        same = measuring.run(truth, truth)
        assert not same.flip_map.any() and same.ssim == 1
        again = measuring.run(shown, truth)  # by the rows of the truth that were kept
        assert np.array_equal(again.flip_map, found) and again.ssim == alike.ssim
    measuring.close()


@pytest.mark.parametrize("turn_rad", [0.0, 0.005, 0.07, 0.4])
def test_flicker_is_that_of_float64(turn_rad, gpu):
    """Places of float32 are off by a few 2**-17 pixels, errors by at most 2 from pixel to pixel."""
    size = 66, 37
    measuring = PairPass(gpu, size, 20.0)
    pairs = [[noise(2 * k + i, size) for i in range(2)] for k in range(2)]
    now, before = (Compared(*pair, turned(angle)) for pair, angle in zip(pairs, (0.0, turn_rad), strict=True))
    for earlier in (before, Compared(before.truth, before.shown, before.view), before):
        measuring.run(now.shown, now.truth)
        wanted = flicker(now.error, now.view, error_image(earlier.shown, earlier.truth), earlier.view)
        assert measuring.flicker(now, earlier) == pytest.approx(wanted, abs=2e-4)
    measuring.close()


def test_flicker_that_only_float64_finds(gpu):
    size = 8, 6
    measuring, picture = PairPass(gpu, size, 20.0), noise(1, size)
    now = Compared(picture, picture, turned(0.0))
    measuring.run(now.shown, now.truth)
    assert measuring.flicker(now, now) == 0
    assert measuring.flicker(now, Compared(picture, picture, turned(3.1))) is None  # nothing in common
    small = Compared(picture[1:], picture[1:], turned(0.0))
    assert measuring.flicker(now, small) is None
    measuring.close()


def test_pictures_that_cannot_be_compared_are_refused(gpu):
    measuring = PairPass(gpu, (4, 3), 20.0)
    with pytest.raises(InputError, match="expected two of the same"):
        measuring.run(np.zeros((3, 4, 3), np.uint8), np.zeros((4, 3, 3), np.uint8))
    measuring.close()
