"""FLIP and SSIM on the GPU against their judges, libraries."""

from __future__ import annotations

import numpy as np
import pytest

from hmdwarp.metrics import PairPass

from .pictures import flip, ssim


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
