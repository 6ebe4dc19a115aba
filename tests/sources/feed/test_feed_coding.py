"""Coded frames: fewer bytes, the pictures of the codec, and hostile bytes are refused."""

import attrs
import numpy as np
import pytest

from hmdwarp.colour import srgb8_from_linear
from hmdwarp.link.codec import Undecodable
from hmdwarp.pipeline.feed_coding import FeedDecoder, FeedEncoder, depth_error
from hmdwarp.sources.feed.message import (
    ANY,
    AV1,
    DEPTH_EXACT,
    DEPTH_VIDEO,
    H264,
    HEVC,
    INVERSE_DEPTH,
    NONE,
    RGBA8,
    VP9,
    FrameMessage,
    Wish,
    decode,
    encode,
    length_of,
)

from .messages import ASK, FRAME

SIZE = (96, 80)
STEP = 2.0**-10


def drawn(number: int, *, light: bool = False) -> FrameMessage:
    """A smooth picture that moves, with sky at its top, in bytes unless in light."""
    x, y = np.meshgrid(np.arange(SIZE[0]) / SIZE[0], np.arange(SIZE[1]) / SIZE[1])
    colour = np.stack([(x + number / 50) % 1, y, 0.5 + 0 * x, np.ones_like(x)], axis=-1).astype(np.float16)
    if not light:
        colour = np.dstack([srgb8_from_linear(colour[..., :3]), np.full_like(x, 255, np.uint8)])
    inverse = np.where(y < 0.2, 0, 0.2 + y / 2).astype(np.float32)
    return attrs.evolve(FRAME, number=1 + number, colours=(colour,) * 2, inverse_depths=(inverse,) * 2)


def asked(colour: int, depth: int) -> FeedEncoder:
    return FeedEncoder(attrs.evolve(ASK, size=SIZE, wish=Wish(colour, depth, rate_hz=60.0, depth_step=STEP)))


@pytest.mark.parametrize("colour", [H264, HEVC, VP9, AV1, RGBA8])
@pytest.mark.parametrize("depth", [DEPTH_EXACT, DEPTH_VIDEO, INVERSE_DEPTH])
def test_coded_frames_come_back_in_fewer_bytes(colour, depth):
    encoder, decoder = asked(colour, depth), FeedDecoder()
    for number in range(3):
        frame = drawn(number)
        crossed = encode(encoder.encode(frame))
        of_bytes, both = colour == RGBA8, colour == RGBA8 and depth == INVERSE_DEPTH
        assert len(crossed) <= len(encode(frame)) / (1 if both else 1.5 if of_bytes or depth == INVERSE_DEPTH else 2)
        back = decoder.decode(decode(crossed))
        off = np.abs(back.light(1).astype(float) - frame.light(1))
        # The codecs' own quality, 40 dB and more on a smooth picture; bytes are within half a step.
        assert off.mean() < 0.02
        # Half a step; as video a third on average, and two are rare.
        depth_off = np.abs(back.inverse_depths[0] - frame.inverse_depths[0])
        # What `depth_error` tells the warps is a bound, but for the few of a video.
        assert depth == DEPTH_VIDEO or depth_off.max() <= depth_error(back, encoder.wish) <= STEP
        assert depth_off.mean() <= STEP and (back.inverse_depths[0] == 0).sum() == (frame.inverse_depths[0] == 0).sum()


@pytest.mark.parametrize("colour", [H264, RGBA8, ANY])
def test_depth_that_is_not_wished_is_left_out_and_all_of_the_picture_counts_as_drawn(colour):
    encoder, decoder = asked(colour, NONE), FeedDecoder()
    for number in range(2):
        frame = drawn(number, light=colour == ANY)
        sent = encoder.encode(attrs.evolve(frame, inverse_depths=(b"",) * 2))
        back = decoder.decode(decode(encode(sent)))
        assert sent.bytes == sum(map(length_of, sent.colours)) and not decoder.wants_anew
        assert back.inverse_depths == (b"",) * 2 and back.size == SIZE
        light = back.light(1)
        assert np.abs(light.astype(float) - frame.light(1)).mean() < 0.02 and (light[..., 3] == 1).all()


@pytest.mark.parametrize("largest", [0.9, 3.0, 300.0])
@pytest.mark.parametrize("wished", [H264, RGBA8])
def test_light_beyond_1_is_kept_where_the_picture_is_light_alone(wished, largest):
    """A byte beyond 1 is a 64th of the powers of 2 that it reaches: of 16 a ratio of 2^(1/4)."""
    frame = drawn(0, light=True)
    colour = (frame.colours[0] * (largest, largest, largest, 1)).astype(np.float16)
    of_eye = {"light": [np.zeros((0, 0))]}
    frame = attrs.evolve(frame, colours=(colour,) * 2, layers=(of_eye,) * 2)
    wish = Wish(wished, INVERSE_DEPTH, crf=0 if wished == H264 else None, rate_hz=60.0)
    back = FeedDecoder().decode(decode(encode(FeedEncoder(attrs.evolve(ASK, size=SIZE, wish=wish)).encode(frame))))
    for eye in (0, 1):
        bright, found = frame.light(eye).astype(float)[..., :3] > 1, back.light(eye).astype(float)
        assert (found[..., 3] == 1).all() and bright.any() == (largest > 1)
        if bright.any():
            ratio = found[..., :3][bright] / frame.light(eye)[..., :3].astype(float)[bright]
            # The rounding of a byte and the codec's at its best are half of that each.
            assert np.median(np.abs(np.log2(ratio))) < 1 / 4 and found.max() > largest / 2
        assert np.median(np.abs(found[..., :3] - frame.light(eye)[..., :3])[~bright]) < 0.02


@pytest.mark.parametrize(("colour", "depth"), [(H264, DEPTH_VIDEO), (RGBA8, DEPTH_EXACT)])
def test_a_stream_is_decoded_from_its_beginning_and_again_after_a_lost_frame(colour, depth):
    encoder, decoder = asked(colour, depth), FeedDecoder()
    first, second, _, third = (encoder.encode(drawn(number)) for number in range(4))
    assert len(encode(second)) < len(encode(first)) or colour == RGBA8, "each frame was coded by itself"
    with pytest.raises(Undecodable):
        decoder.decode(second)
    assert decoder.wants_anew and decoder.decode(first)
    if colour == H264:  # whose frames need those before them
        with pytest.raises(Undecodable):
            decoder.decode(third)
        assert decoder.wants_anew
    assert decoder.decode(asked(colour, depth).encode(drawn(4)))
    assert not decoder.wants_anew
