"""Depth in steps of a sixteenth of a pixel, and as a video: bounds, exact values, losses."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from hmdwarp.geometry import Fov, Pose, View, WarpMap
from hmdwarp.link.codec import (
    PARALLAX_PIXELS,
    DepthDecoder,
    DepthEncoder,
    DepthVideoDecoder,
    DepthVideoEncoder,
    Packet,
    Undecodable,
    depth_step,
)

SIZES = hnp.array_shapes(min_dims=2, max_dims=2, min_side=1, max_side=33)
VALUES = st.one_of(st.sampled_from([0.0, -1.0, 1e-6, 20.0, 1.0]), st.floats(0, 20, width=32))
ANYTHING = hnp.arrays(np.float32, SIZES, elements=VALUES)
STEPS = st.floats(2.0**-11, 2.0**-7)  # at which 20 per metre fit into 16 bits
STEP = 2.0**-8


def planes(width: int, height: int, count: int = 1) -> list[np.ndarray]:
    """Slanted planes behind one another with sky and a hole; they move by a pixel a picture."""
    y, x = np.mgrid[:height, :width]
    out = []
    for k in range(count):
        picture = 0.4 + 0.001 * (x + k) + 0.0007 * y
        picture[(x + k > width / 3) & (y > height / 4)] = 1.3
        picture[(x + k > width / 2) & (y < height / 2)] = 0
        picture[(x < 3) & (y > 5)] = -1
        out.append(picture.astype(np.float32))
    return out


@given(
    st.floats(20, 2000),
    st.floats(0.01, 2),
    st.floats(0, 2 * np.pi),
    st.floats(0, 4),
    st.tuples(st.floats(0, 1), st.floats(0, 1)),
)
def test_half_a_step_moves_no_pixel_by_more_than_a_sixteenth(size, age_s, angle, inverse_depth, place):
    """By the warp map, which is linear in inverse depth for a way across the line of sight.

    Where the step is at its least, the bound is that of the least.
    """
    step = depth_step(size / 2, age_s)
    way = np.array([np.cos(angle), np.sin(angle), 0]) * 1.0 * age_s  # a walking head
    fov, square = Fov.symmetric(np.pi / 2, np.pi / 2), (round(size), round(size))
    warp = WarpMap.between(View(Pose(), fov), square, View(Pose(tuple(way)), fov), square)
    pixel = np.array(place) * size
    ends = [warp.apply(pixel, np.array(depth))[0] for depth in (inverse_depth, inverse_depth + step / 2)]
    bound = max(PARALLAX_PIXELS, 2.0**-15 * size / 2 * age_s) * (1 + 1 / size)  # the rounded size
    assert np.linalg.norm(ends[1] - ends[0]) <= bound * (1 + 1e-6) + 1e-9


def test_steps_stay_what_warps_and_16_bits_can_take():
    assert depth_step(150, 0) == depth_step(150, 1e-6) == 2.0**-7
    assert depth_step(1e6, 10) == 2.0**-14
    assert depth_step(300, 0.2) == pytest.approx(depth_step(150, 0.2) / 2) == pytest.approx(depth_step(150, 0.4))


@settings(max_examples=100)
@given(ANYTHING, STEPS)
def test_every_pixel_within_half_a_step(inverse, step):
    """Of the power of 2 at or below it; sky and holes exactly, 10^6 m and 5 cm as any other."""
    size = inverse.shape[::-1]
    got = DepthDecoder(size).decode(DepthEncoder(size, step).encode(inverse))
    assert ((got == -1) == (inverse < 0)).all() and ((got == 0) == (inverse == 0)).all()
    taken = 2.0 ** np.floor(np.log2(step))
    assert (np.abs(got.astype(float) - inverse)[inverse > 0] <= taken / 2).all()


@settings(max_examples=25)
@given(ANYTHING)
def test_a_video_keeps_sky_and_holes_of_any_picture(inverse):
    size = inverse.shape[::-1]
    got = DepthVideoDecoder(size).decode(DepthVideoEncoder(size, 60, STEP).encode(inverse))
    assert got.dtype == np.float32 and got.shape == inverse.shape and np.isfinite(got).all()
    assert ((got == -1) == (inverse < 0)).all() and ((got == 0) == (inverse == 0)).all()


@pytest.mark.parametrize("distance", [0.05, 0.3, 2.0, 50.0, 1e6])
def test_a_flat_picture_comes_back_from_a_video(distance):
    """The quantiser's step at qp 22, 7.9, is two codes of a flat block of 4x4.

    Less than 5/8 of it is lost, and half a code by rounding: 1.75 codes.
    A code is half a step, and for near things as much more as its bend says.
    """
    inverse = np.full((48, 64), 1 / distance, np.float32)
    inverse[:, 40:] = 0.3
    got = DepthVideoDecoder((64, 48)).decode(DepthVideoEncoder((64, 48), 60, STEP).encode(inverse))
    code = STEP / 2
    # K log(1 + 32 / K code) is 1023 at K = 240.
    code *= 1 + (1 / distance) / (240 * code) if distance == 0.05 else 1
    assert np.abs(got - inverse)[:, 8:32].max() <= 1.75 * code


def test_what_came_near_once_costs_nothing_after_the_next_key_frame():
    far = np.full((48, 64), 0.3, np.float32) + np.linspace(0, 0.1, 64, dtype=np.float32)
    encoder, decoder = DepthVideoEncoder((64, 48), 60, STEP), DepthVideoDecoder((64, 48))
    for picture in (np.full_like(far, 20.0), far):
        encoder.request_key()
        found = decoder.decode(encoder.encode(picture))
    alone = DepthVideoDecoder((64, 48)).decode(DepthVideoEncoder((64, 48), 60, STEP).encode(far))
    assert np.array_equal(found, alone)


def test_a_video_of_moving_planes_is_near_and_light():
    pictures = planes(160, 120, 8)
    encoder, decoder = DepthVideoEncoder((160, 120), 60, STEP), DepthVideoDecoder((160, 120))
    packets = [encoder.encode(picture) for picture in pictures]
    assert [packet.key for packet in packets] == [True] + [False] * 7
    for packet, picture in zip(packets, pictures, strict=True):
        assert np.abs(decoder.decode(packet) - picture).mean() <= STEP / 2
    alone = DepthEncoder((160, 120), STEP)
    assert sum(p.size_bytes for p in packets[1:]) < 0.7 * sum(len(alone.encode(p)) for p in pictures[1:])


def test_approaching_depths_are_coded_without_a_key_frame():
    pictures = [np.full((48, 64), depth, np.float32) for depth in (0.5, 9.0, 0.5)]
    encoder, decoder = DepthVideoEncoder((64, 48), 60, STEP), DepthVideoDecoder((64, 48))
    for picture in pictures:
        assert decoder.decode(encoder.encode(picture)) == pytest.approx(picture, rel=0.02)


def test_depths_after_a_lost_one_are_undecodable_until_a_key_frame():
    encoder, packets = DepthVideoEncoder((64, 48), 60, STEP), []
    for number, picture in enumerate(planes(64, 48, 6)):
        if number == 4:
            encoder.request_key()
        packets.append(encoder.encode(picture))
    whole, lossy = DepthVideoDecoder((64, 48)), DepthVideoDecoder((64, 48))
    shown = [whole.decode(packet) for packet in packets]
    assert (lossy.decode(packets[0]) == shown[0]).all()
    for packet in packets[2:4]:
        with pytest.raises(Undecodable):
            lossy.decode(packet)
    for packet, picture in zip(packets[4:], shown[4:], strict=True):
        assert (lossy.decode(packet) == picture).all()


def test_damaged_depth_of_a_video_is_undecodable():
    packet = DepthVideoEncoder((64, 48), 60, STEP).encode(planes(64, 48)[0])
    decoder = DepthVideoDecoder((64, 48))
    turned = bytes([*packet.data[:40], packet.data[40] ^ 1, *packet.data[41:]])
    for data in (b"", packet.data[:9], packet.data[:-2], turned):
        with pytest.raises(Undecodable):
            decoder.decode(Packet(0, True, data))
    with pytest.raises(Undecodable):
        DepthVideoDecoder((128, 96)).decode(packet)
    decoder.decode(packet)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_video_refuses_what_is_no_number(bad):
    encoder = DepthVideoEncoder((2, 1), 60, STEP)
    with pytest.raises(ValueError, match="expected finite numbers"):
        encoder.encode(np.array([[1, bad]], np.float32))
    with pytest.raises(ValueError, match="expected"):
        encoder.encode(np.zeros((3, 3), np.float32))
