"""What any layer weighs packed."""

from __future__ import annotations

import numpy as np
import pytest

from hmdwarp.link.codec import packed_bytes


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.uint32, np.float16, np.float32])
@pytest.mark.parametrize("shape", [(40, 50), (40, 50, 4), (1, 1), (40, 50, 1)])
def test_a_layer_of_one_value_weighs_next_to_nothing_and_noise_what_it_is(dtype, shape):
    bits = np.random.default_rng(1).integers(0, 256, np.prod(shape) * np.dtype(dtype).itemsize, np.uint8)
    noise = bits.view(dtype).reshape(shape)
    assert packed_bytes(np.full(shape, 7, dtype)) <= 20 + noise.nbytes // 100 * 2
    assert noise.nbytes <= packed_bytes(noise) <= noise.nbytes + 20


def test_nothing_weighs_nothing():
    assert packed_bytes(np.zeros((0, 5, 4), np.float16)) == 0


def test_a_view_weighs_what_it_shows():
    whole = np.arange(64 * 64, dtype=np.uint32).reshape(64, 64)
    assert packed_bytes(whole[::2, ::2]) == packed_bytes(whole[::2, ::2].copy())
