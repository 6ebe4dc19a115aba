"""Frames through real codecs. What comes back, what a lost one costs, and what is said where a
codec is missing."""

from __future__ import annotations

import functools
import os
import sys
from pathlib import Path

import attrs
import numpy as np
import pytest

from hmdwarp.base import (
    InputError,
    MachineError,
    UnknownNameError,
    linear_from_srgb,
    picture_from_linear,
    srgb_from_linear,
)
from hmdwarp.link.codec import (
    Codec,
    Coding,
    Decoder,
    DepthEncoder,
    DepthVideoDecoder,
    DepthVideoEncoder,
    Encoder,
    Undecodable,
    codecs,
)

pytest.importorskip("av")
VIDEO = [codec.name for codec in codecs if not codec.is_none]
COARSE = 2.0**-8


def usable(name: str) -> Codec:
    try:
        codecs.get(name).check()
    except MachineError as error:
        pytest.skip(str(error))
    return codecs.get(name)


@pytest.fixture(params=VIDEO)
def codec(request):
    return usable(request.param)


@functools.cache
def frames(size=(160, 120), count=12) -> list[np.ndarray]:
    """A wall with waves, a box passing before it, sky above, and a hole; as encoders take them."""
    width, height = size
    y, x = np.mgrid[:height, :width].astype(np.float64)
    out = []
    for k in range(count):
        colour = np.stack([128 + 60 * np.sin((x + 2 * k) / 9), 90 + y * 80 / height, 120 + 50 * np.cos(y / 7)], -1)
        colour[: height // 5] = (90, 150, 230)
        colour[(abs(x - width / 3 - 2 * k) < width / 8) & (abs(y - height / 2) < height / 5)] = (220, 40, 30)
        out.append(opaque(colour.astype(np.uint8)))
        out[-1][(x - 0.8 * width) ** 2 + (y - 0.7 * height) ** 2 < (height / 9) ** 2] = 0
    return out


def psnr(a, b) -> float:
    """Of two pictures in linear light, as a display shows them."""
    wrong = picture_from_linear(a).astype(float) - picture_from_linear(b)
    return 10 * np.log10(255**2 / np.mean(wrong**2))


def patches(count: int = 48) -> tuple[np.ndarray, np.ndarray]:
    """Flat squares of 32x32 in random colours and the corners of the colour cube; the colours."""
    rng = np.random.default_rng(5)
    corners = np.stack(np.meshgrid([0, 255], [0, 255], [0, 255]), -1).reshape(-1, 3)
    colours = np.concatenate([corners, rng.integers(0, 256, (count - 8, 3))]).astype(np.uint8)
    return colours.reshape(6, count // 6, 3).repeat(32, 0).repeat(32, 1), colours


def opaque(colour: np.ndarray) -> np.ndarray:
    """Linear light with coverage in alpha, of sRGB bytes."""
    return np.dstack([linear_from_srgb(colour), np.ones(colour.shape[:2])]).astype(np.float16)


def there_and_back(codec, picture: np.ndarray, **how) -> np.ndarray:
    size = picture.shape[1::-1]
    return Decoder(codec.name, size).decode(Encoder(codec.name, size, 60, **how).encode(picture))


@pytest.mark.parametrize(("crf", "bound", "lean"), [(1, 3.2, 0.75), (None, 5.2, 1.6)])
def test_flat_colours_come_back(codec, crf, bound, lean):
    """The bound is that of limited range and of the codec. 219 steps of luma and 224 of chroma:
    half a step of luma is 0.58 levels, of chroma at most 1.06 (blue), and rounding back to bytes
    0.5: 2.2 levels. The codec adds 1 at its best and 3 at its ordinary setting, where the step of a
    flat block is 5 to 6 and less than half of it is lost. A mistaken matrix (BT.601) or range is
    off by 16 and more."""
    picture, colours = patches()
    got = picture_from_linear(there_and_back(codec, opaque(picture), crf=crf))
    middles = got[16::32, 16::32].reshape(-1, 3).astype(int)
    assert np.abs(middles - colours).max() <= bound
    # Nor do they lean to the dark or the bright: each of the parts above is spread evenly, which
    # has a deviation of 1/sqrt(3) of its bound; together 0.95 and 1.9 levels, and the mean of 40
    # colours is within 5 / sqrt(40) of that.
    assert np.abs((middles - colours)[8:].mean(axis=0)).max() <= lean


def test_partial_coverage_comes_back_within_half_a_step_and_light_without_any_is_kept(codec):
    """254 steps of coverage: half of one is 1/508, and half floats round to 2^-12 below 1. What is
    premultiplied stays so: light is coded as it is."""
    picture = opaque(patches()[0])
    share = np.linspace(0, 1, picture.shape[1], dtype=np.float32).astype(np.float16)
    picture[..., :3] *= share[:, None]
    picture[..., 3] = share
    picture[:32] = 0
    picture[32:64] = (0.5, 0.5, 0.5, 0)  # a glow
    picture[64:96, :32] = (0, 0, 0, 0.7)  # a shadow
    got = there_and_back(codec, picture, crf=1)
    assert np.abs(got[..., 3].astype(float) - picture[..., 3]).max() <= 1 / 508 + 2**-12
    whole = (picture[..., 3] == 0) | (picture[..., 3] == 1)
    assert (got[whole][:, 3] == picture[whole][:, 3]).all()
    assert (got[:32] == 0).all()
    # 3.2 levels, see test_flat_colours_come_back
    assert np.abs(as_shown(got)[40:56] - as_shown(picture)[40:56]).max() <= 3.2
    assert as_shown(got)[72:88, 8:24].max() <= 3.2


def as_shown(picture: np.ndarray) -> np.ndarray:
    return srgb_from_linear(np.minimum(picture[..., :3], 1)) * 255


@pytest.mark.parametrize("most", [1.5, 4.0, 100.0, 65504.0])
def test_light_beyond_1_is_kept_where_it_is_asked_for_and_clipped_elsewhere(codec, most):
    """Up to 1 the bytes have 191 steps of sRGB, beyond it 64 of equal ratios up to the next of 2,
    4, 16, 256, 65536; the codec adds its 3.2 levels."""
    levels = np.concatenate([np.linspace(0, 1, 24) ** 2.2, np.geomspace(1, most, 24)]).astype(np.float16)
    flat = levels.reshape(6, 8).repeat(32, 0).repeat(32, 1)
    picture = np.dstack([flat, flat, flat, np.ones_like(flat)])
    kept, clipped = (
        there_and_back(codec, picture, crf=1, keeps_beyond_1=keeps)[16::32, 16::32, 1].ravel().astype(float)
        for keeps in (True, False)
    )
    stops = next(stops for stops in (1, 2, 4, 8, 16) if most <= 2**stops)
    dim = srgb_from_linear(np.minimum(kept[:24], 1)) - srgb_from_linear(levels[:24].astype(float))
    assert np.abs(dim).max() <= 3.2 / 191
    assert np.abs(np.log2(np.maximum(kept[24:], 0.9) / levels[24:])).max() <= 3.2 / 64 * stops + 2**-10
    assert clipped.max() <= 1 and clipped[24:].min() > 0.95


def test_the_scale_of_bright_light_falls_with_a_key_frame_only(codec):
    """Another scale changes every block; without one, a frame like the last is next to nothing.
    After the key frame the picture is as good as one that was never bright."""
    encoder, decoder = Encoder(codec.name, (160, 120), 60, keeps_beyond_1=True), Decoder(codec.name, (160, 120))
    bright = frames()[0].copy()
    bright[50:60, 50:60, :3] = 8
    sizes = [len(encoder.encode(picture).data) for picture in (bright, frames()[0], frames()[0])]
    after, plain = encoder.encode(frames()[0], key=True), Encoder(codec.name, (160, 120), 60).encode(frames()[0])
    quality = [psnr(decoder.decode(packet), frames()[0]) for packet in (after, plain)]
    assert quality[0] == pytest.approx(quality[1], abs=0.2)
    assert max(sizes[1:]) < sizes[0] / 3


@pytest.mark.skipif(sys.platform != "linux", reason="threads are listed on Linux alone")
def test_no_thread_takes_the_machine_for_itself(codec):
    """Run by root, SVT-AV1 asks for real time: an X server beside it waited for ever."""
    encoder = Encoder(codec.name, (160, 120), 60)
    for picture in frames()[:2]:
        encoder.encode(picture)
    policies = {os.sched_getscheduler(int(thread.name)) for thread in Path("/proc/self/task").iterdir()}
    assert policies <= {os.SCHED_OTHER, os.SCHED_BATCH}


@pytest.mark.parametrize("axis", [0, 1])
def test_chroma_stays_where_it_is(codec, axis):
    """It lay half a pixel left: coded from between two pixels, decoded as from the left one."""
    wave = 60 * np.sin(2 * np.pi * np.arange(192) / 24 + 0.7)
    line = 120 + wave[:, None] * (0, -0.1873, 1.8556)  # one luma, waves of Cb
    picture = opaque(np.broadcast_to(line[None] if axis else line[:, None], (192, 192, 3)).round().astype(np.uint8))
    blue = (srgb_from_linear(one[..., 2].astype(float)) for one in (picture, there_and_back(codec, picture, crf=2)))
    before, after = (np.fft.rfft(values.mean(axis=1 - axis)[24:-24])[6] for values in blue)  # of six waves
    # Bytes and the codec blur a wave of 60 steps by about one: a sixtieth of a radian, 0.06 pixels.
    assert abs(np.angle(after / before) / (2 * np.pi) * 24) < 0.06


@pytest.mark.parametrize("size", [(160, 120), (161, 121), (17, 16), (1, 1), (3, 200), (64, 63)])
def test_each_frame_of_any_size_comes_out_before_the_next_goes_in(codec, size):
    """No picture is held back by either side: the one decoded is the one just encoded."""
    encoder, decoder, drawn = Encoder(codec.name, size, 60), Decoder(codec.name, size), frames(size)
    for k, picture in enumerate(drawn):
        got = decoder.decode(encoder.encode(picture))
        assert got.shape == picture.shape and got.dtype == np.float16
        if size[0] > 100:
            assert psnr(got, picture) > 30 and max(range(len(drawn)), key=lambda n: psnr(got, drawn[n])) == k


Y, X = np.mgrid[:96, :96]
HOLES = {"disc": np.hypot(X - 47, Y - 50) < 20, "rows": (Y < 31) | ((Y >= 64) & (Y < 81)), "all": Y >= 0}


@pytest.mark.parametrize("holes", HOLES)
@pytest.mark.parametrize("nothing", [(0, 0, 0), (1, 1, 1), (0.25, 3, 0.5)])
def test_holes_come_back_exactly_and_do_not_darken_what_is_beside_them(codec, holes, nothing):
    """Whatever stands for nothing: where all light passes it is 1, and a codec would take some. A
    bright wall keeps its brightness up to its holes, within what the codec does elsewhere."""
    picture, hole = opaque(np.full((96, 96, 3), 200, np.uint8)), HOLES[holes]
    picture[hole] = (*nothing, 0)
    got = there_and_back(codec, picture)
    assert (got[hole] == picture[hole]).all() and (got[..., 3] == picture[..., 3]).all()
    assert np.abs(picture_from_linear(got)[~hole].astype(int) - 200).max(initial=0) <= 3


def moving_depths() -> list[np.ndarray]:
    """Slanted planes behind one another with sky and a hole; they move by a pixel a picture."""
    y, x = np.mgrid[:120, :160]
    out = []
    for k in range(12):
        picture = 0.4 + 0.001 * (x + k) + 0.0007 * y
        picture[(x + k > 53) & (y > 30)] = 1.3
        picture[(x + k > 80) & (y < 60)] = 0
        picture[(x < 3) & (y > 5)] = -1
        out.append(picture.astype(np.float32))
    return out


@pytest.mark.parametrize("name", [*VIDEO, "depth"])
def test_frames_after_a_lost_one_are_undecodable_until_a_key_frame(name):
    """And from there on it is, bit for bit, what a client sees that lost nothing."""
    size, lost, key = (160, 120), 4, 8
    if name == "depth":
        encoder, pictures = DepthVideoEncoder(size, 60, COARSE), moving_depths()
        whole, lossy = DepthVideoDecoder(size), DepthVideoDecoder(size)
    else:
        usable(name)
        encoder, pictures, whole, lossy = Encoder(name, size, 60), frames(), Decoder(name, size), Decoder(name, size)
    packets = [encoder.encode(picture, key=k == key) for k, picture in enumerate(pictures)]
    assert [packet.number for packet in packets] == list(range(12))
    assert [packet.number for packet in packets if packet.key] == [0, key]
    for packet, picture in zip(packets, pictures, strict=True):
        expected = whole.decode(packet)
        assert name != "depth" or np.abs(expected - picture).mean() <= COARSE / 2
        if lost < packet.number < key:
            with pytest.raises(Undecodable, match="builds on one that never came"):
                lossy.decode(packet)
        elif packet.number != lost:
            assert (lossy.decode(packet) == expected).all()
    if name == "depth":
        alone = DepthEncoder(size, COARSE)
        deltas = [(packet, picture) for packet, picture in zip(packets, pictures, strict=True) if not packet.key]
        assert sum(len(p.data) for p, _ in deltas) < 0.7 * sum(len(alone.encode(picture)) for _, picture in deltas)


def test_damage_is_undecodable_until_the_next_key_frame_and_nothing_is_printed(codec, capfd):
    encoder, decoder = Encoder(codec.name, (160, 120), 60), Decoder(codec.name, (160, 120))
    first, second, third = (encoder.encode(picture) for picture in frames()[:3])

    def turned_over(packet, place):
        return attrs.evolve(
            packet, data=packet.data[:place] + bytes([packet.data[place] ^ 255]) + packet.data[place + 1 :]
        )

    for damaged in (
        attrs.evolve(first, data=b""),
        attrs.evolve(first, data=bytes(len(first.data))),
        *(turned_over(first, place) for place in range(0, len(first.data), 97)),
        Encoder(codec.name, (80, 60), 60).encode(frames((80, 60))[0]),
    ):
        with pytest.raises(Undecodable):
            decoder.decode(damaged)
    with pytest.raises(Undecodable):
        Decoder(codec.name, (320, 240)).decode(first)
    assert psnr(decoder.decode(first), frames()[0]) > 30
    with pytest.raises(Undecodable, match="damaged picture"):
        decoder.decode(turned_over(second, len(second.data) - 1))
    with pytest.raises(Undecodable, match="builds on"):
        decoder.decode(third)
    del encoder, decoder
    assert capfd.readouterr() == ("", "")


def test_bytes_are_those_of_the_settings(codec):
    """A rate is kept by noise, after the first pictures within a quarter; the same twice."""
    rng, encoder = np.random.default_rng(2), Encoder(codec.name, (160, 120), 60, bitrate_mbit=1.0)
    shown = [opaque(rng.integers(0, 256, (120, 160, 3), np.uint8)) for _ in range(30)]
    shown += [opaque(np.full((120, 160, 3), 128, np.uint8))] * 30 + shown[:10]
    mbit = [len(encoder.encode(picture).data) * 8 * 60 / 1e6 for picture in shown]
    assert np.mean(mbit[10:30]) == pytest.approx(1, rel=0.25)
    assert np.mean(mbit[60:]) < 3, "still pictures save little for what comes"
    twice = Encoder(codec.name, (160, 120), 60), Encoder(codec.name, (160, 120), 60)
    assert all(twice[0].encode(picture) == twice[1].encode(picture) for picture in frames()[:5])
    coarse, fine = (Encoder(codec.name, (160, 120), 60, crf=crf).encode(frames()[0]) for crf in (40, 10))
    assert len(coarse.data) * 2 < len(fine.data)
    plain, bright = (Encoder(codec.name, (160, 120), 60, keeps_beyond_1=keeps).encode(frames()[1]) for keeps in (0, 1))
    assert plain == bright, "nothing in it is brighter than 1"


LACKS = "built without the {}, which codec 'h264' needs: install PyAV from its wheel"
REFUSED = [
    (lambda: Coding("h264", crf=60), InputError, "crf 60: expected 0"),
    (lambda: Encoder("h264", (64, 64), 60, crf=60), InputError, "crf 60: expected 0"),
    (lambda: Encoder("none", (64, 64), 60), InputError, "encodes nothing: expected one of av1, h264, hevc, vp9"),
    (lambda: Coding("h264", crf=-1), InputError, "crf -1"),
    (lambda: Coding("h264", bitrate_mbit=0), InputError, "bitrate 0 Mbit/s"),
    (lambda: Coding("h264", bitrate_mbit=float("nan")), InputError, "bitrate nan"),
    (lambda: Coding("h264", crf=20, bitrate_mbit=5), InputError, "not both"),
    (lambda: codecs.get("h265").check(), UnknownNameError, "did you mean 'h264'"),
    # As it is for a PyAV built without it: FFmpeg does not know the name.
    (lambda: Codec("h264", "", "libx999", "h264", crf=20).check(), MachineError, LACKS.format("encoder 'libx999'")),
    (lambda: Codec("h264", "", "libx264", "h999", crf=20).check(), MachineError, LACKS.format("decoder 'h999'")),
    (lambda: Codec("h264", "", "libx264", "h999", crf=20).check(), MachineError, "codec 'none'"),
]  # fmt: skip


@pytest.mark.parametrize(("make", "error", "message"), REFUSED, ids=[message[:20] for *_, message in REFUSED])
def test_what_cannot_be_coded_is_refused(make, error, message):
    with pytest.raises(error, match=message):
        make()


def test_an_encoder_refuses_what_it_does_not_take(codec):
    """x264 and x265 take no pictures of a million pixels a side."""
    said = f"encoder '{codec.encoder}' does not take pictures of 1000000x1000000 at 60 Hz"
    with pytest.raises(MachineError, match=said):
        Encoder(codec.name, (10**6, 10**6), 60)
    encoder = Encoder(codec.name, (64, 48), 60)
    good = np.zeros((48, 64, 4), np.float16)
    for bad in (good[:, :-1], good.astype(np.float32), good[..., :3]):
        with pytest.raises(ValueError, match=r"expected float16 of shape \(48, 64, 4\)"):
            encoder.encode(bad)
    assert encoder.encode(good).key  # nothing has gone wrong for the next
