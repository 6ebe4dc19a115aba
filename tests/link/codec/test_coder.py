"""Frames through real codecs.

What comes back, what a lost one costs, and what is said where a codec is missing.
"""

from __future__ import annotations

import functools

import attrs
import numpy as np
import pytest
from coded_frames import moving

from hmdwarp.colour import linear_from_srgb
from hmdwarp.errors import InputError, MachineError, UnknownNameError
from hmdwarp.link.codec import STEP, Codec, Decoder, Encoder, Undecodable, check_codec, codecs

pytest.importorskip("av")
VIDEO = [codec.name for codec in codecs if not codec.is_none]


@pytest.fixture(params=VIDEO)
def codec(request):
    try:
        return check_codec(request.param)
    except MachineError as error:
        pytest.skip(str(error))


@functools.cache
def frames(size=(160, 120), count=12):
    return moving(size, count)


def psnr(a, b) -> float:
    return 10 * np.log10(255**2 / np.mean((a.astype(float) - b) ** 2))


def patches(count: int = 48) -> tuple[np.ndarray, np.ndarray]:
    """Flat squares of 32x32 in random colours and the corners of the colour cube; the colours."""
    rng = np.random.default_rng(5)
    corners = np.stack(np.meshgrid([0, 255], [0, 255], [0, 255]), -1).reshape(-1, 3)
    colours = np.concatenate([corners, rng.integers(0, 256, (count - 8, 3))]).astype(np.uint8)
    return colours.reshape(6, count // 6, 3).repeat(32, 0).repeat(32, 1), colours


@pytest.mark.parametrize(("crf", "bound", "lean"), [(1, 3.2, 0.75), (None, 5.2, 1.6)])
def test_flat_colours_come_back(codec, crf, bound, lean):
    """The bound is that of limited range and of the codec.

    219 steps of luma and 224 of chroma: half a step of luma is 0.58 levels, of chroma at most 1.06
    (blue), and rounding back to bytes 0.5: 2.2 levels. The codec adds 1 at its best and 3 at its
    ordinary setting, where the step of a flat block is 5 to 6 and less than half of it is lost. A
    mistaken matrix (BT.601) or range is off by 16 and more.
    """
    picture, colours = patches()
    height, width = picture.shape[:2]
    depth = np.ones((height, width), np.float32)
    packet = Encoder(codec, (width, height), 60, crf=crf).encode(picture, depth)
    got = Decoder(codec, (width, height)).decode(packet).colour
    middles = got[16::32, 16::32].reshape(-1, 3).astype(int)
    assert np.abs(middles - colours).max() <= bound
    # Nor do they lean to the dark or the bright: each of the parts above is spread evenly, which
    # has a deviation of 1/sqrt(3) of its bound; together 0.95 and 1.9 levels, and the mean of 40
    # colours is within 5 / sqrt(40) of that.
    assert np.abs((middles - colours)[8:].mean(axis=0)).max() <= lean


@pytest.mark.parametrize("size", [(160, 120), (161, 121), (17, 16), (1, 1), (3, 200), (64, 63)])
def test_any_size_comes_back(codec, size):
    encoder, decoder = Encoder(codec, size, 60), Decoder(codec, size)
    for colour, inverse in moving(size, 3):
        picture = decoder.decode(encoder.encode(colour, inverse))
        assert picture.colour.shape == colour.shape
        assert picture.inverse_depth.shape == inverse.shape
        drawn = inverse >= 0
        assert (picture.colour[~drawn] == 0).all()
        if size[0] > 100:
            assert psnr(picture.colour[drawn], colour[drawn]) > 30


def test_each_frame_comes_out_before_the_next_goes_in(codec):
    """No picture is held back by either side.

    The one decoded is the one just encoded, not one before.
    """
    encoder, decoder = Encoder(codec, (160, 120), 60), Decoder(codec, (160, 120))
    originals = [colour for colour, _ in frames()]
    for k, (colour, inverse) in enumerate(frames()):
        got = decoder.decode(encoder.encode(colour, inverse)).colour
        assert max(range(len(originals)), key=lambda n: psnr(got, originals[n])) == k


def test_depth_and_holes_come_back(codec):
    encoder, decoder = Encoder(codec, (160, 120), 60), Decoder(codec, (160, 120))
    for colour, inverse in frames()[:3]:
        picture = decoder.decode(encoder.encode(colour, inverse))
        hole = inverse < 0
        assert ((picture.inverse_depth == -1) == hole).all()
        assert (np.abs(picture.inverse_depth - inverse)[~hole] <= STEP / 2).all()
        rgba = picture.rgba()
        assert rgba.dtype == np.float16
        assert (rgba[hole] == 0).all()
        assert (rgba[~hole][:, 3] == 1).all()
        assert np.allclose(rgba[..., :3], linear_from_srgb(picture.colour), rtol=2**-11, atol=1e-7)


def test_holes_do_not_darken_what_is_beside_them(codec):
    """The ring around a black disc of holes on a bright wall keeps its brightness, to within what
    the codec does elsewhere.
    """
    colour = np.full((96, 96, 3), 200, np.uint8)
    inverse = np.ones((96, 96), np.float32)
    y, x = np.mgrid[:96, :96]
    radius = np.hypot(x - 47, y - 50)
    colour[radius < 20], inverse[radius < 20] = 0, -1
    got = Decoder(codec, (96, 96)).decode(Encoder(codec, (96, 96), 60).encode(colour, inverse)).colour
    assert np.abs(got[(radius >= 20) & (radius < 22)].astype(int) - 200).max() <= 3


def test_a_picture_of_holes_alone(codec):
    colour, inverse = np.zeros((70, 70, 3), np.uint8), np.full((70, 70), -1, np.float32)
    picture = Decoder(codec, (70, 70)).decode(Encoder(codec, (70, 70), 60).encode(colour, inverse))
    assert (picture.colour == 0).all()
    assert (picture.inverse_depth == -1).all()


def test_what_follows_a_lost_frame_is_undecodable_until_a_key_frame(codec):
    """And from there on it is, bit for bit, what a client sees that lost nothing."""
    encoder = Encoder(codec, (160, 120), 60)
    packets = []
    for k, (colour, inverse) in enumerate(frames()):
        if k == 8:
            encoder.request_key()
        packets.append(encoder.encode(colour, inverse))
    assert [packet.key for packet in packets] == [k in (0, 8) for k in range(12)]
    assert [packet.number for packet in packets] == list(range(12))
    whole, lossy = Decoder(codec, (160, 120)), Decoder(codec, (160, 120))
    for packet in packets:
        expected = whole.decode(packet)
        if packet.number == 4:
            continue
        if 4 < packet.number < 8:
            with pytest.raises(Undecodable, match="builds on one that never came"):
                lossy.decode(packet)
        else:
            assert (lossy.decode(packet).colour == expected.colour).all()


def test_a_lost_key_frame_costs_all_until_the_next(codec):
    encoder, decoder = Encoder(codec, (160, 120), 60, key_every_s=4 / 60), Decoder(codec, (160, 120))
    packets = [encoder.encode(*frame) for frame in frames()]
    assert [packet.number for packet in packets if packet.key] == [0, 4, 8]
    decoded = []
    for packet in packets[1:]:
        try:
            decoder.decode(packet)
        except Undecodable:
            continue
        decoded.append(packet.number)
    assert decoded == list(range(4, 12))


def test_damaged_packets_are_undecodable_and_the_next_key_frame_is_not(codec):
    encoder, decoder = Encoder(codec, (160, 120), 60), Decoder(codec, (160, 120))
    first = encoder.encode(*frames()[0])
    for damaged in (
        attrs.evolve(first, colour=b""),
        attrs.evolve(first, colour=bytes(len(first.colour))),
        attrs.evolve(first, depth=first.depth[:-9]),
        attrs.evolve(first, depth=Encoder(codec, (80, 60), 60).encode(*moving((80, 60), 1)[0]).depth),
    ):
        with pytest.raises(Undecodable):
            decoder.decode(damaged)
    with pytest.raises(Undecodable):
        Decoder(codec, (320, 240)).decode(first)
    assert psnr(decoder.decode(first).colour, frames()[0][0]) > 30


def test_what_follows_damage_depends_on_what_was_damaged(codec):
    """Pictures build on the colour before them, not on the depth."""
    encoder, decoder = Encoder(codec, (160, 120), 60), Decoder(codec, (160, 120))
    packets = [encoder.encode(*frame) for frame in frames()[:5]]
    decoder.decode(packets[0])
    with pytest.raises(Undecodable, match="damaged depth"):
        decoder.decode(attrs.evolve(packets[1], depth=b""))
    decoder.decode(packets[2])
    with pytest.raises(Undecodable, match="damaged colour"):
        decoder.decode(attrs.evolve(packets[3], colour=b""))
    with pytest.raises(Undecodable, match="builds on"):
        decoder.decode(packets[4])


def test_the_same_frames_make_the_same_bytes(codec):
    def coded():
        encoder = Encoder(codec, (160, 120), 60)
        return [encoder.encode(*frame) for frame in frames()[:5]]

    assert coded() == coded()


def test_a_rate_is_kept(codec):
    """Noise, which costs as much as it is given.

    After the first picture, within a quarter of the rate.
    """
    rng = np.random.default_rng(2)
    encoder = Encoder(codec, (160, 120), 60, bitrate_mbit=1.0)
    depth = np.ones((120, 160), np.float32)
    sizes = [len(encoder.encode(rng.integers(0, 256, (120, 160, 3), np.uint8), depth).colour) for _ in range(30)]
    assert np.mean(sizes[10:]) * 8 * 60 == pytest.approx(1e6, rel=0.25)


def test_quality_can_be_asked_for(codec):
    coarse, fine = (Encoder(codec, (160, 120), 60, crf=crf).encode(*frames()[0]) for crf in (40, 10))
    assert len(coarse.colour) * 2 < len(fine.colour)


def test_nothing_is_printed(codec, capfd):
    encoder, decoder = Encoder(codec, (160, 120), 60), Decoder(codec, (160, 120))
    for frame in frames()[:2]:
        decoder.decode(encoder.encode(*frame))
    with pytest.raises(Undecodable):
        decoder.decode(attrs.evolve(encoder.encode(*frames()[2]), colour=bytes(100)))
    del encoder, decoder
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"crf": 60}, "crf 60: expected 0"),
        ({"crf": -1}, "crf -1"),
        ({"bitrate_mbit": 0}, "bitrate 0 Mbit/s"),
        ({"bitrate_mbit": float("nan")}, "bitrate nan"),
        ({"crf": 20, "bitrate_mbit": 5}, "not both"),
        ({"key_every_s": 0}, "key frames every 0 s"),
    ],
)
def test_settings_that_cannot_be_meant(settings, message):
    with pytest.raises(InputError, match=message):
        Encoder("h264", (64, 64), 60, **settings)


def test_frames_of_another_shape_are_refused(codec):
    encoder = Encoder(codec, (64, 48), 60)
    good, depth = np.zeros((48, 64, 3), np.uint8), np.ones((48, 64), np.float32)
    for colour, inverse in ((good[:, :-1], depth), (good.astype(np.float32), depth), (good, depth[:-1])):
        with pytest.raises(ValueError, match=r"expected uint8 of shape \(48, 64, 3\)"):
            encoder.encode(colour, inverse)
    assert encoder.encode(good, depth).key  # nothing has gone wrong for the next


def test_names():
    assert codecs.names() == ["h264", "hevc", "none"]
    with pytest.raises(UnknownNameError, match="did you mean 'h264'"):
        check_codec("h265")
    assert check_codec("none").is_none
    with pytest.raises(InputError, match="codec 'none' encodes nothing: expected one of h264, hevc"):
        Encoder("none", (64, 64), 60)


@pytest.mark.parametrize(
    ("encoder", "decoder", "missing"), [("libx999", "h264", "encoder 'libx999'"), ("libx264", "h999", "decoder 'h999'")]
)
def test_a_codec_that_this_pyav_lacks(encoder, decoder, missing):
    """As it is for a PyAV built without it: FFmpeg does not know the name."""
    lacking = Codec("h264", "", encoder, decoder, crf=20)
    with pytest.raises(
        MachineError, match=f"built without the {missing}, which codec 'h264' needs: install PyAV from its wheel"
    ) as caught:
        lacking.check()
    assert "codec 'none'" in str(caught.value)


def test_an_encoder_that_does_not_open(codec):
    """x264 and x265 refuse pictures of a million pixels a side."""
    with pytest.raises(
        MachineError, match=f"encoder '{codec.encoder}' does not take pictures of 1000000x1000000 at 60 Hz"
    ):
        Encoder(codec, (10**6, 10**6), 60)
