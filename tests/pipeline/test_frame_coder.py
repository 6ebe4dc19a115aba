"""Every layer of a frame through its coding, and nothing that is not read."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pytest

from hmdwarp.client import build_plan
from hmdwarp.colour import srgb_from_linear
from hmdwarp.frames import Needs
from hmdwarp.frames.layers import BRIGHT_VIDEO, DEPTH, PACKED, VECTORS, VIDEO, layers
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import download, upload
from hmdwarp.link.codec import DEPTH_CODES, DEPTH_VIDEOS, Coding
from hmdwarp.pipeline import Coder, Reads
from hmdwarp.scenes import load_scene
from hmdwarp.sources.server import Server

pytest.importorskip("av")
SIZE = (128, 96)
VIEWS = [View(Pose((x, 1.6, 1.0)), Fov.symmetric(1.0, 0.8)) for x in (-0.03, 0.03)]
# Everything that a server can draw beside the picture.
EVERYTHING = Needs(**{layer.name: layer.something for layer in layers if layer.drawn_by})
DRAWN = [layer.name for layer in layers if layer.formats]
DEEP = [name for name in DRAWN if DEPTH in layers.get(name).coded_as()]


def reads_of(*names: str) -> Reads:
    needs = Needs(**{name: EVERYTHING[name] for name in names if name in EVERYTHING})
    return Reads(frozenset(layers.get(name).readable() for name in names), needs)


@pytest.fixture
def server(gpu):
    made = Server(gpu, load_scene("planes"))
    yield made
    made.close()


def blocks(rng: np.random.Generator, values: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Flat squares of 32 pixels, (h, w, channels), each of one of the rows of `values`."""
    width, height = size
    chosen = values[rng.integers(0, len(values), (-(-height // 32), -(-width // 32)))]
    return chosen.repeat(32, 0).repeat(32, 1)[:height, :width]


def content(rng: np.random.Generator, coding: str, size: tuple[int, int], like: np.ndarray) -> np.ndarray:
    """What a texture of that coding may hold: at its extremes, with holes and edges."""
    height, width = size[::-1]
    holes = rng.random((height, width)) < 0.2
    if coding in (VIDEO, BRIGHT_VIDEO):
        out = np.ones((height, width, 4), np.float16)
        out[..., :3] = blocks(rng, rng.random((40, 3)) * (8 if coding == BRIGHT_VIDEO else 1), size)
        out[holes] = 0
        return out
    if coding == DEPTH:
        return np.where(holes, -1, rng.choice([0, 0.1, 3, 40], (height, width)) * rng.random((height, width))).astype(
            np.float32
        )
    if coding == VECTORS:
        out = rng.normal(size=(height, width, 4)).astype(np.float16)
        out[..., 3] = ~holes
        out[holes] = 0
        return out
    return rng.integers(0, 65536, like.shape).astype(like.dtype)


def check(coding: str, before: np.ndarray, after: np.ndarray, depth_error: float) -> None:
    assert after.shape == before.shape
    if coding == PACKED:
        assert (after == before).all()
    elif coding == DEPTH:
        assert ((after == -1) == (before == -1)).all() and ((after == 0) == (before == 0)).all()
        assert np.abs(after - before).max() <= depth_error
    elif coding == VECTORS:
        assert (after[..., 3] == before[..., 3]).all() and (after[before[..., 3] == 0] == 0).all()
        # Half a step, and the half float that the texture rounds it to.
        assert (np.abs(after.astype(float) - before) <= 2.0**-11 + np.abs(before) * 2.0**-11).all()
    else:
        assert (after[..., 3] == before[..., 3]).all() and (after[before[..., 3] == 0] == 0).all()
        # 3.2 of 255 levels at crf 1, see tests/link/codec/test_coder.py; where light reaches 8, 191
        # levels are for what is below 1 and 64 for the four stops above.
        most = before[..., :3].max()
        one = 255 if most <= 1 else 191
        middle = np.zeros(before.shape[:2], bool)
        middle[16::32, 16::32] = True
        covered = middle & (before[..., 3] == 1)
        assert covered.sum() > middle.sum() / 3
        old, new = (picture[covered][:, :3].astype(float) for picture in (before, after))
        levels = [one * srgb_from_linear(np.minimum(x, 1)) + 16 * np.log2(np.maximum(x, 1)) for x in (old, new)]
        assert np.abs(levels[0] - levels[1]).max() <= 3.2


@pytest.mark.parametrize(("name", "depth"), [*((name, "exact") for name in DRAWN), *product(DEEP, DEPTH_CODES[1:])])
def test_arrived_layers_are_within_the_bound_of_their_coding(server, name, depth):
    """Everything that passes read is overwritten before it is decoded: nothing slips by.

    A video bounds no pixel of noise; that what is no depth stays so is checked all the same.
    """
    layer, reads, rng = layers.get(name), reads_of(name), np.random.default_rng(7)
    coder = Coder(Coding("h264", crf=1, depth=depth), 60, 0.2)
    for number in range(3):
        frame = server.draw_frame(VIEWS, number, SIZE, needs=reads.needs)
        parts = [part for _, each, data in reads.contents(frame) for part in each.coded(data)]
        assert len(parts) % len(layer.formats) == 0 and parts
        before = []
        for texture, coding in parts:
            before.append(content(rng, coding, texture.size, download(texture)))
            upload(texture, before[-1])
        coded = coder.encode(frame, reads, wants_key=False)
        assert {key[1] for key in coded.packets} == {name} and len(coded.packets) == len(parts)
        videos = {VIDEO, BRIGHT_VIDEO, *([DEPTH] if depth in DEPTH_VIDEOS else [])}
        assert coded.is_key == (number == 0) or not videos & set(layer.coded_as())
        for texture, _ in parts:
            upload(texture, np.full_like(download(texture), 3))
        assert coder.receive(coded)
        for (texture, coding), drawn in zip(parts, before, strict=True):
            check(
                coding, drawn, download(texture), math.inf if depth in DEPTH_VIDEOS else coded.frame.eyes[0].depth_error
            )
        server.recycle(frame)


def test_a_frame_is_undecodable_until_each_of_its_streams_has_its_key_frame(server):
    reads = reads_of("colour", "cube", "inverse_depth")
    coder = Coder(Coding("h264"), 60, 0.2)
    frames = [server.draw_frame(VIEWS, number, SIZE, needs=reads.needs) for number in range(4)]
    coded = [coder.encode(frame, reads, wants_key=number == 3) for number, frame in enumerate(frames)]
    assert [frame.is_key for frame in coded] == [True, False, False, True]
    assert coder.receive(coded[0])
    assert not coder.receive(coded[2]), "the one before it never came"
    assert coder.receive(coded[3])
    for frame in frames:
        server.recycle(frame)


@pytest.mark.parametrize("depth", DEPTH_CODES)
def test_a_frame_says_how_wrong_its_depth_may_be(server, depth):
    """Frames of planes; half a step of 2^-10 at most for the exact code, more for the others."""
    reads, coder = reads_of("inverse_depth"), Coder(Coding("h264", depth=depth), 60, 0.2)
    for number in range(3):
        frame = server.draw_frame(VIEWS, number, SIZE, needs=reads.needs)
        before = [download(eye.inverse_depth) for eye in frame.eyes]
        coded = coder.encode(frame, reads, wants_key=False)
        assert coder.receive(coded) and frame.eyes[0].depth_error == 0
        for drawn, eye in zip(before, coded.frame.eyes, strict=True):
            assert eye.depth_error >= 2.0**-11 and (eye.depth_error == 2.0**-11) == (depth == "exact")
            wrong = np.abs(download(eye.inverse_depth) - drawn)
            assert (wrong <= eye.depth_error).mean() >= (0.98 if depth == "video" else 1)
        server.recycle(coded.frame)


def test_a_bit_rate_is_that_of_an_eye_however_many_videos_it_has(server):
    """Noise, which costs as much as it is given; the first frame costs more."""
    rng, totals = np.random.default_rng(1), []
    for names in (("colour",), ("colour", "cube"), ("colour", "peeled")):
        reads, coder, sizes = reads_of(*names), Coder(Coding("h264", bitrate_mbit=3.0), 60, 0.2), []
        for number in range(16):
            frame = server.draw_frame(VIEWS[:1], number, SIZE, needs=reads.needs)
            for _, layer, data in reads.contents(frame):
                for texture, coding in layer.coded(data):
                    if coding == VIDEO:
                        upload(texture, rng.random((*texture.size[::-1], 3)).astype(np.float16))
            coded = coder.encode(frame, reads, wants_key=False)
            videos = [packet.size_bytes for (_, _, part), packet in coded.packets.items() if part % 2 == 0]
            sizes.append(sum(videos))
            server.recycle(frame)
        totals.append(np.mean(sizes[6:]) * 8 * 60 / 1e6)
    assert totals == pytest.approx([3.0] * 3, rel=0.3)


# --- what is read --------------------------------------------------------------------------------


def plan(warp: str, fill: str = "none", effects: tuple[str, ...] = ()):
    return build_plan(effects, warp, fill, "none", client_geometry=True)


def test_only_peeled_surfaces_that_are_read_are_coded(server):
    frame = server.draw_frame(VIEWS, 0, SIZE, needs=Needs(peeled=3))
    coder = Coder(Coding("h264"), 60, 0.2)
    coded = coder.encode(frame, Reads.of([plan("layered:layers=2")]), wants_key=False)
    assert sum(name == "peeled" for _, name, _ in coded.packets) == 2 * 2
    server.recycle(frame)
