"""FLIP on the GPU against flip-evaluator, its judge."""

from __future__ import annotations

import numpy as np
import pytest

from hmdwarp.errors import InputError
from hmdwarp.metrics import FlipPass, flip


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
def test_it_is_the_library_s(size, pixels_per_degree, gpu):
    """Maps within 1e-3 and means within 1e-5, which is what float32 leaves of the same formulas."""
    measuring = FlipPass(gpu, size, pixels_per_degree)
    for shown, truth in pictures(size, seed=size[0]):
        mean, wanted = flip(shown, truth, pixels_per_degree)
        found = measuring.run(shown, truth)
        assert found == pytest.approx(wanted, abs=1e-3)
        assert found.mean(dtype=np.float64) == pytest.approx(mean, abs=1e-5)
        assert not measuring.run(truth, truth).any()
    measuring.close()


def test_pictures_that_cannot_be_compared_are_refused(gpu):
    measuring = FlipPass(gpu, (4, 3), 20.0)
    with pytest.raises(InputError, match="expected two of the same"):
        measuring.run(np.zeros((3, 4, 3), np.uint8), np.zeros((4, 3, 3), np.uint8))
    measuring.close()
