"""Layers that no video codec handles: packed exactly, or vectors within half a step."""

from __future__ import annotations

import contextlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from hmdwarp.link.codec import Undecodable, VectorDecoder, VectorEncoder, pack, unpack

STEP = 2.0**-10
TYPES = (np.uint8, np.uint16, np.uint32, np.float16, np.float32)
SHAPES = hnp.array_shapes(min_dims=1, max_dims=3, min_side=0, max_side=9)
VECTORS = hnp.arrays(
    np.float16, (7, 5, 3), elements=st.one_of(st.sampled_from([0.0, -0.0, 1.0, -1.0]), st.floats(-40, 40, width=16))
)


@settings(max_examples=100)
@given(st.sampled_from(TYPES).flatmap(lambda kind: hnp.arrays(kind, SHAPES)))
def test_packed_layers_come_back_to_the_bit(layer):
    got = unpack(pack(layer))
    assert got.dtype == layer.dtype and got.shape == layer.shape
    assert got.tobytes() == layer.tobytes()


@pytest.mark.parametrize("dtype", TYPES)
@pytest.mark.parametrize("shape", [(40, 50), (40, 50, 4), (1, 1), (40, 50, 1)])
def test_a_layer_of_one_value_weighs_next_to_nothing_and_noise_what_it_is(dtype, shape):
    bits = np.random.default_rng(1).integers(0, 256, np.prod(shape) * np.dtype(dtype).itemsize, np.uint8)
    noise = bits.view(dtype).reshape(shape)
    assert len(pack(np.full(shape, 7, dtype))) <= 120
    assert noise.nbytes <= len(pack(noise)) <= noise.nbytes + 60


def test_a_mask_of_one_value_weighs_no_more_for_being_large():
    assert len(pack(np.full((2000, 2000), 255, np.uint8))) < 120


def test_a_view_is_packed_as_what_it_shows():
    whole = np.arange(64 * 64, dtype=np.uint32).reshape(64, 64)
    assert pack(whole[::2, ::2]) == pack(whole[::2, ::2].copy())


@settings(max_examples=60)
@given(st.binary(max_size=60))
def test_any_bytes_are_unpacked_or_called_undecodable(data):
    with contextlib.suppress(Undecodable):
        unpack(data)
    with contextlib.suppress(Undecodable):
        VectorDecoder((5, 7), 3).decode(data)


@settings(max_examples=60)
@given(VECTORS)
def test_each_vector_by_itself(vectors):
    """Within half a step, which is doubled above 32; 0 and 1 exactly."""
    got = VectorDecoder((5, 7), 3).decode(VectorEncoder((5, 7), 3).encode(vectors))
    step = STEP if np.abs(vectors).max() <= (2**15 - 1) * STEP else 2 * STEP
    assert np.abs(got - vectors.astype(np.float64)).max() <= step / 2
    whole = (vectors == 0) | (np.abs(vectors) == 1)
    assert (got[whole] == vectors[whole]).all()


def test_vectors_of_one_value_weigh_next_to_nothing():
    assert len(VectorEncoder((300, 200), 4).encode(np.full((200, 300, 4), 0.3, np.float16))) < 100


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_vectors_that_are_none_are_refused(bad):
    with pytest.raises(ValueError, match="expected finite numbers"):
        VectorEncoder((1, 1), 2).encode(np.array([[[1, bad]]], np.float32))


def test_damage_to_vectors_is_noticed():
    vectors = np.random.default_rng(1).uniform(-2, 2, (20, 30, 2)).astype(np.float16)
    data, decoder = VectorEncoder((30, 20), 2).encode(vectors), VectorDecoder((30, 20), 2)
    for place in range(0, len(data), 11):
        with pytest.raises(Undecodable):
            decoder.decode(data[:place] + bytes([data[place] ^ 255]) + data[place + 1 :])
    with pytest.raises(Undecodable):
        VectorDecoder((31, 20), 2).decode(data)
    assert np.abs(decoder.decode(data) - vectors).max() <= STEP / 2
