"""The code of inverse depth.

Every pixel within half a step of itself, whatever lies beside it; sky and holes exactly.
"""

from __future__ import annotations

import contextlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from hmdwarp.link.codec import STEP, DepthDecoder, DepthEncoder, Undecodable

SHAPES = hnp.array_shapes(min_dims=2, max_dims=2, min_side=1, max_side=33)
SPECIAL = st.sampled_from([0.0, -1.0, STEP, STEP / 2, 64.0, 2.0**-149, 1.0])
VALUES = st.one_of(SPECIAL, st.floats(0, 70, width=32), st.floats(0, 2.0**-8, width=32))
ANYTHING = hnp.arrays(np.float32, SHAPES, elements=VALUES)


def encode_depth(inverse: np.ndarray) -> bytes:
    return DepthEncoder(inverse.shape[::-1]).encode(inverse)


def decode_depth(data: bytes, shape: tuple[int, int]) -> np.ndarray:
    return DepthDecoder(shape[::-1]).decode(data)


def there_and_back(inverse: np.ndarray) -> np.ndarray:
    return decode_depth(encode_depth(inverse), inverse.shape)


def check(inverse: np.ndarray, step: float = STEP) -> None:
    got = there_and_back(inverse)
    assert got.dtype == np.float32
    assert got.shape == inverse.shape
    hole, sky = inverse < 0, inverse == 0
    # Codes of their own, both ways.
    assert ((got == -1) == hole).all()
    assert ((got == 0) == sky).all()
    rest = ~hole & ~sky
    # Half a step; the last bit of a float32 of 17 bits is exact, so nothing is added to that.
    assert (np.abs(got[rest].astype(np.float64) - inverse[rest]) <= step / 2).all()


@settings(max_examples=150)
@given(ANYTHING)
def test_each_pixel_by_itself(inverse):
    """Random neighbours are nothing but edges.

    A code that took anything from beside a pixel would fail at once.
    """
    check(inverse, STEP * 2 if inverse.max(initial=0) > 65534 * STEP else STEP)


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1), st.integers(1, 6), st.integers(2, 70), st.integers(2, 50))
def test_random_edges_between_surfaces(seed, edges, width, height):
    """Half-planes cut through slanted planes, sky and holes, at any angle."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:height, :width]
    inverse = np.full((height, width), 0.05)
    for _ in range(edges):
        angle = rng.uniform(0, 2 * np.pi)
        side = (x - rng.uniform(0, width)) * np.cos(angle) + (y - rng.uniform(0, height)) * np.sin(angle) > 0
        plane = rng.uniform(0.1, 20) + rng.uniform(-1e-2, 1e-2) * x + rng.uniform(-1e-2, 1e-2) * y
        inverse = np.where(side, rng.choice([0.0, -1.0]) if rng.random() < 0.3 else np.maximum(plane, 0), inverse)
    check(inverse.astype(np.float32))


def test_an_edge_between_near_and_far_stays_one():
    inverse = np.full((64, 64), 0.1, np.float32)
    inverse[np.add.outer(np.arange(64), 2 * np.arange(64)) > 90] = 10
    got = there_and_back(inverse)
    assert len(np.unique(got)) == 2


def test_coding_a_second_time_changes_nothing():
    """A code decodes to the middle of what it stands for, so coded values are fixed points."""
    inverse = np.random.default_rng(1).uniform(0, 5, (20, 30)).astype(np.float32)
    once = there_and_back(inverse)
    assert (there_and_back(once) == once).all()


@pytest.mark.parametrize(
    ("nearest", "factor"), [(63.99, 1), (64.0, 2), (1000.0, 16), (1e30, 2.0**94), (3.4e38, 2.0**122)]
)
def test_depths_nearer_than_the_code_reaches_enlarge_its_steps(nearest, factor):
    inverse = np.array([[nearest, 1.0, 0.0, -1.0, 1e-40]], np.float32)
    check(inverse, STEP * factor)


@pytest.mark.parametrize("shape", [(1, 1), (1, 500), (500, 1), (15, 17), (16, 16)])
def test_any_shape(shape):
    check(np.full(shape, 0.5, np.float32))


def test_all_holes_and_all_sky():
    check(np.full((9, 9), -1, np.float32))
    check(np.zeros((9, 9), np.float32))
    check(-np.zeros((2, 2), np.float32))


def test_any_negative_number_is_no_depth():
    got = there_and_back(np.array([[-0.001, -1e30, -np.inf]], np.float32))
    assert (got == -1).all()


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_numbers_that_are_none_are_refused(bad):
    with pytest.raises(ValueError, match="expected finite numbers"):
        encode_depth(np.array([[1, bad]], np.float32))


def test_planes_cost_next_to_nothing():
    """2^16 values of a slanted plane in less than a bit each, where raw they take 32."""
    y, x = np.mgrid[:256, :256]
    assert len(encode_depth((0.3 + 0.001 * x + 0.0007 * y).astype(np.float32))) < 65536 / 8


def test_a_stream_of_pictures_each_by_itself():
    """The last can be decoded without the others, and the encoder does not remember.

    Equal pictures make equal bytes.
    """
    rng = np.random.default_rng(4)
    pictures = [rng.uniform(0, 5, (20, 30)).astype(np.float32) for _ in range(3)]
    encoder, decoder = DepthEncoder((30, 20)), DepthDecoder((30, 20))
    data = [encoder.encode(picture) for picture in [*pictures, pictures[0]]]
    assert data[3] == data[0] == encode_depth(pictures[0])
    for k in (2, 0, 1, 1):
        assert np.abs(decoder.decode(data[k]) - pictures[k]).max() <= STEP / 2


def test_damage_is_noticed():
    """Bytes missing, or any of them turned over: a checksum covers all."""
    inverse = np.random.default_rng(1).uniform(0, 5, (20, 30)).astype(np.float32)
    data, decoder = encode_depth(inverse), DepthDecoder((30, 20))
    for damaged in (b"", data[:1], data[:5], data[:-3], data + b"x"):
        with pytest.raises(Undecodable):
            decoder.decode(damaged)
    for place in range(0, len(data), 7):
        with pytest.raises(Undecodable):
            decoder.decode(data[:place] + bytes([data[place] ^ 255]) + data[place + 1 :])
    assert np.abs(decoder.decode(data) - inverse).max() <= STEP / 2
    with pytest.raises(Undecodable):
        DepthDecoder((31, 20)).decode(data)


@settings(max_examples=60)
@given(st.binary(max_size=80))
def test_any_bytes_are_decoded_or_called_undecodable(data):
    with contextlib.suppress(Undecodable):
        decode_depth(data, (20, 30))
