"""Codes that bound the error of every value: depth, depth in coarser steps, vectors, packed layers.
And depth as a video, which bounds most."""

from __future__ import annotations

import contextlib
import zlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from hmdwarp.geometry import Fov, Pose, View, WarpMap
from hmdwarp.link.codec import (
    PARALLAX_PIXELS,
    STEP,
    DepthDecoder,
    DepthEncoder,
    DepthVideoDecoder,
    DepthVideoEncoder,
    Packet,
    Undecodable,
    VectorDecoder,
    VectorEncoder,
    depth_step,
    pack,
    unpack,
)

SHAPES = hnp.array_shapes(min_dims=2, max_dims=2, min_side=1, max_side=33)
SPECIAL = st.sampled_from([0.0, -1.0, STEP, STEP / 2, 64.0, 2.0**-149, 1.0, 20.0])
VALUES = st.one_of(SPECIAL, st.floats(0, 70, width=32), st.floats(0, 2.0**-8, width=32))
ANYTHING = hnp.arrays(np.float32, SHAPES, elements=VALUES)
NEAR = hnp.arrays(np.float32, SHAPES, elements=st.one_of(st.sampled_from([0.0, -1.0]), st.floats(0, 20, width=32)))
HALVES = st.one_of(st.sampled_from([0.0, -0.0, 1.0, -1.0, 32.0]), st.floats(-40, 40, width=16))
VECTORS = hnp.arrays(np.float16, (7, 5, 3), elements=HALVES)
TYPES = (np.uint8, np.uint16, np.uint32, np.float16, np.float32)
RNG = np.random.default_rng(1)
NOISE = RNG.uniform(0, 5, (20, 30)).astype(np.float32)
COARSE = 2.0**-8


def there_and_back(inverse: np.ndarray, *step: float) -> np.ndarray:
    size = inverse.shape[::-1]
    return DepthDecoder(size).decode(DepthEncoder(size, *step).encode(inverse))


def check(inverse: np.ndarray, step: float = STEP, *asked: float) -> None:
    """Half a step: the last bit of a float32 of 17 bits is exact, so nothing is added to that."""
    got = there_and_back(inverse, *asked)
    assert got.dtype == np.float32 and got.shape == inverse.shape
    assert ((got == -1) == (inverse < 0)).all() and ((got == 0) == (inverse == 0)).all()
    assert (np.abs(got.astype(np.float64) - inverse)[inverse > 0] <= step / 2).all()


@settings(max_examples=150)
@given(ANYTHING)
def test_each_pixel_by_itself(inverse):
    """Random neighbours are edges: a code that took anything from beside a pixel would fail."""
    check(inverse, STEP * 2 if inverse.max(initial=0) > 65534 * STEP else STEP)


@settings(max_examples=100)
@given(NEAR, st.floats(2.0**-11, 2.0**-7))
def test_every_pixel_within_half_a_step_that_is_asked_for(inverse, step):
    """Of the power of 2 at or below it: 20 per metre fit into 16 bits of each."""
    check(inverse, 2.0 ** np.floor(np.log2(step)), step)


@pytest.mark.parametrize(
    ("nearest", "factor"), [(63.99, 1), (64.0, 2), (1000.0, 16), (1e30, 2.0**94), (3.4e38, 2.0**122)]
)
def test_depths_nearer_than_the_code_reaches_enlarge_its_steps(nearest, factor):
    check(np.array([[nearest, 1.0, 0.0, -1.0, 1e-40]], np.float32), STEP * factor)


def test_depth_of_any_shape_and_kind_keeps_what_it_is():
    for shape in ((1, 1), (1, 500), (500, 1), (15, 17), (16, 16)):
        check(np.full(shape, 0.5, np.float32))
    for value in (-1.0, 0.0, -0.0):
        check(np.full((9, 9), value, np.float32))
    assert (there_and_back(np.array([[-0.001, -1e30, -np.inf]], np.float32)) == -1).all()
    edge = np.full((64, 64), 0.1, np.float32)
    edge[np.add.outer(np.arange(64), 2 * np.arange(64)) > 90] = 10
    assert len(np.unique(there_and_back(edge))) == 2, "an edge stays one"
    # A code decodes to the middle of what it stands for, so coded values are fixed points.
    once = there_and_back(NOISE)
    assert (there_and_back(once) == once).all()
    encoder = DepthEncoder((30, 20))
    first, _, again = (encoder.encode(picture.copy()) for picture in (NOISE, NOISE[::-1], NOISE))
    assert first == again, "each by itself"


def test_what_is_even_costs_next_to_nothing_and_noise_what_it_is():
    y, x = np.mgrid[:256, :256]
    # 2^16 values of a slanted plane in less than a bit each, where raw they take 32.
    assert len(DepthEncoder((256, 256)).encode((0.3 + 0.001 * x + 0.0007 * y).astype(np.float32))) < 65536 / 8
    assert len(VectorEncoder((300, 200), 4).encode(np.full((200, 300, 4), 0.3, np.float16))) < 100
    assert len(pack(np.full((2000, 2000), 255, np.uint8))) < 120
    for dtype in TYPES:
        for shape in ((40, 50), (40, 50, 4), (1, 1), (40, 50, 1)):
            noise = RNG.integers(0, 256, np.prod(shape) * np.dtype(dtype).itemsize, np.uint8).view(dtype).reshape(shape)
            assert len(pack(np.full(shape, 7, dtype))) <= 120
            assert noise.nbytes <= len(pack(noise)) <= noise.nbytes + 60


def a_picture(slanted: bool = True) -> np.ndarray:
    y, x = np.mgrid[:20, :30]
    return (0.4 + slanted * (0.001 * x + 0.0007 * y)).astype(np.float32)


VIDEO = DepthVideoEncoder((30, 20), 60, COARSE).encode(a_picture())
CODED = {
    "depth": (DepthEncoder((30, 20)).encode(NOISE), lambda data, size=(30, 20): DepthDecoder(size).decode(data)),
    "vectors": (
        VectorEncoder((30, 20), 2).encode(RNG.uniform(-2, 2, (20, 30, 2)).astype(np.float16)),
        lambda data, size=(30, 20): VectorDecoder(size, 2).decode(data),
    ),
    "video": (VIDEO.data, lambda data, size=(30, 20): DepthVideoDecoder(size).decode(Packet(0, True, data))),
}


@pytest.mark.parametrize("code", CODED)
def test_damage_is_noticed(code):
    """A checksum covers all but the length of the last of vectors, which may be too large."""
    data, decoded = CODED[code]
    right = decoded(data)
    torn = zlib.crc32(data[4:12]).to_bytes(4, "little") + data[4:12]  # the head alone, and its own checksum
    for missing in (b"", data[:1], data[:5], data[:9], data[:-3], torn):
        with pytest.raises(Undecodable):
            decoded(missing)
    for place in range(0, len(data), 7):
        with contextlib.suppress(Undecodable):
            found = decoded(data[:place] + bytes([data[place] ^ 255]) + data[place + 1 :])
            assert code == "vectors" and np.array_equal(found, right), place
    with pytest.raises(Undecodable):
        decoded(data, (31, 20))


@settings(max_examples=60)
@given(st.binary(max_size=80))
def test_any_bytes_are_decoded_or_called_undecodable(data):
    for _, decoded in CODED.values():
        with contextlib.suppress(Undecodable):
            decoded(data)
    with contextlib.suppress(Undecodable):
        unpack(data)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_numbers_that_are_none_are_refused(bad):
    for encoder, values in (
        (DepthEncoder((2, 1)), [[1, bad]]),
        (DepthVideoEncoder((2, 1), 60, COARSE), [[1, bad]]),
        (VectorEncoder((1, 1), 2), [[[1, -bad]]]),
    ):
        with pytest.raises(ValueError, match="expected finite numbers"):
            encoder.encode(np.array(values, np.float32))
    with pytest.raises(ValueError, match="expected"):
        DepthVideoEncoder((2, 1), 60, COARSE).encode(np.zeros((3, 3), np.float32))


@settings(max_examples=100)
@given(st.sampled_from(TYPES).flatmap(lambda kind: hnp.arrays(kind, hnp.array_shapes(max_dims=3, min_side=0))))
def test_packed_layers_come_back_to_the_bit(layer):
    got = unpack(pack(layer))
    assert got.dtype == layer.dtype and got.shape == layer.shape and got.tobytes() == layer.tobytes()
    assert pack(layer[::2]) == pack(layer[::2].copy()), "a view is packed as what it shows"


@settings(max_examples=60)
@given(VECTORS)
def test_each_vector_by_itself(vectors):
    """Within half a step, which is doubled above 32; 0 and 1 exactly."""
    got = VectorDecoder((5, 7), 3).decode(VectorEncoder((5, 7), 3).encode(vectors))
    step = 2.0**-10 if np.abs(vectors).max() <= (2**15 - 1) * 2.0**-10 else 2.0**-9
    assert np.abs(got - vectors.astype(np.float64)).max() <= step / 2
    whole = (vectors == 0) | (np.abs(vectors) == 1)
    assert (got[whole] == vectors[whole]).all()


@given(
    st.floats(20, 2000), st.floats(0.01, 2), st.floats(0, 2 * np.pi), st.floats(0, 4), st.floats(0, 1), st.floats(0, 1)
)
def test_half_a_step_moves_no_pixel_by_more_than_a_sixteenth(size, age_s, angle, inverse_depth, x, y):
    """By the warp map, which is linear in inverse depth for a way across the line of sight. Where
    the step is at its least, the bound is that of the least."""
    step = depth_step(size / 2, age_s)
    way = np.array([np.cos(angle), np.sin(angle), 0]) * 1.0 * age_s  # a walking head
    fov, square = Fov.symmetric(np.pi / 2, np.pi / 2), (round(size), round(size))
    warp = WarpMap.between(View(Pose(), fov), square, View(Pose(tuple(way)), fov), square)
    pixel = np.array((x, y)) * size
    ends = [warp.apply(pixel, np.array(depth))[0] for depth in (inverse_depth, inverse_depth + step / 2)]
    bound = max(PARALLAX_PIXELS, 2.0**-15 * size / 2 * age_s) * (1 + 1 / size)  # the rounded size
    assert np.linalg.norm(ends[1] - ends[0]) <= bound * (1 + 1e-6) + 1e-9


def test_steps_stay_what_warps_and_16_bits_can_take():
    assert depth_step(150, 0) == depth_step(150, 1e-6) == 2.0**-7
    assert depth_step(1e6, 10) == 2.0**-14
    assert depth_step(300, 0.2) == pytest.approx(depth_step(150, 0.2) / 2) == pytest.approx(depth_step(150, 0.4))


# --- depth as a video ---


def video_of(pictures, keys=()) -> list[Packet]:
    encoder = DepthVideoEncoder(pictures[0].shape[::-1], 60, COARSE)
    return [encoder.encode(picture, key=number in keys) for number, picture in enumerate(pictures)]


def shown(packets, size) -> list[np.ndarray]:
    decoder = DepthVideoDecoder(size)
    return [decoder.decode(packet) for packet in packets]


@settings(max_examples=25)
@given(NEAR)
def test_a_video_keeps_sky_and_holes_of_any_picture(inverse):
    (got,) = shown(video_of([inverse]), inverse.shape[::-1])
    assert got.dtype == np.float32 and got.shape == inverse.shape and np.isfinite(got).all()
    assert ((got == -1) == (inverse < 0)).all() and ((got == 0) == (inverse == 0)).all()


@pytest.mark.parametrize("distance", [0.05, 0.3, 2.0, 50.0, 1e6])
def test_a_flat_picture_comes_back_from_a_video(distance):
    """The quantiser's step at qp 22, 7.9, is two codes of a flat block of 4x4. Less than 5/8 of it
    is lost, and half a code by rounding: 1.75 codes. A code is half a step, and for near things as
    much more as its bend says."""
    inverse = np.full((48, 64), 1 / distance, np.float32)
    inverse[:, 40:] = 0.3
    (got,) = shown(video_of([inverse]), (64, 48))
    code = COARSE / 2
    # K log(1 + 32 / K code) is 1023 at K = 240.
    code *= 1 + (1 / distance) / (240 * code) if distance == 0.05 else 1
    assert np.abs(got - inverse)[:, 8:32].max() <= 1.75 * code


def test_a_video_follows_what_comes_near_and_forgets_it_with_a_key_frame():
    pictures = [np.full((48, 64), depth, np.float32) for depth in (0.5, 9.0, 0.5)]
    for found, picture in zip(shown(video_of(pictures), (64, 48)), pictures, strict=True):
        assert found == pytest.approx(picture, rel=0.02)
    far = np.full((48, 64), 0.3, np.float32) + np.linspace(0, 0.1, 64, dtype=np.float32)
    after = shown(video_of([np.full_like(far, 20.0), far], keys=(0, 1)), (64, 48))[1]
    assert np.array_equal(after, *shown(video_of([far]), (64, 48)))
