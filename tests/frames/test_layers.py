"""Layers of frames: what their entries say, and things that cross in fragments."""

from __future__ import annotations

import typing

import attrs
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hmdwarp.base import UnknownNameError
from hmdwarp.client.effects import ExpandPass, effects
from hmdwarp.client.fills import fills
from hmdwarp.client.warps import warps
from hmdwarp.frames import EyeImage, EyeSizes, Mirrored, Needs, Others, Surface, frame_bytes
from hmdwarp.frames.layers import FRAGMENT_BYTES, OWN, PIXEL_BYTES, RENDERED, SHOWN, Inbox, Layer, Outbox, layers
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.scenes import load_scene
from hmdwarp.sources.server import Server
from hmdwarp.sources.server.parts import parts

SIZE = (24, 20)
FOV = Fov.symmetric(1.0, 0.8)
# Everything that a server can draw beside the picture.
EVERYTHING = Needs(**{layer.name: layer.something for layer in layers if layer.drawn_by})
GL_FORMAT = {(4, "f2"): "rgba16f", (1, "f4"): "r32f", (1, "u2"): "r16ui"}


def test_everything_drawn_is_declared_and_everything_declared_is_drawn(gpu):
    server = Server(gpu, load_scene("planes"))
    views = [View(Pose((x, 1.6, 1.0)), FOV) for x in (-0.03, 0.03)]
    frame = server.draw_frame(views, 0, SIZE, needs=EVERYTHING)
    for eye in frame.eyes:
        assert {layer.name for layer, _ in eye.contents()} == {*EVERYTHING, "colour", "inverse_depth"}
    server.close()


@pytest.mark.parametrize("name", [layer.name for layer in layers if layer.formats])
def test_formats_and_bytes_are_those_of_the_textures(gpu, name):
    layer = layers.get(name)
    needs = Needs() if layer.always else Needs(**{name: EVERYTHING[name]})
    server = Server(gpu, load_scene("planes"))
    frame = server.draw_frame([View(Pose(), FOV)], 0, SIZE, needs=needs)
    (data,) = [data for each, data in frame.eyes[0].contents() if each is layer]
    textures = list(layer.textures(data))
    found = [GL_FORMAT[texture.components, texture.dtype] for texture in textures]
    assert found == list(layer.formats) * (len(found) // len(layer.formats))
    weight = sum(
        PIXEL_BYTES[one] * texture.width * texture.height for one, texture in zip(found, textures, strict=True)
    )
    for eyes, share in ((1, 1), (2, 1 if layer.per_frame else 2)):
        assert frame_bytes(needs, EyeSizes(SIZE, SIZE, (FOV,) * eyes), eyes=eyes)[layer.readable()] == share * weight
    server.recycle(frame)
    assert not any(server.pool(texture.size, depth=depth).live for texture in textures for depth in (True, False))
    server.close()


@pytest.mark.parametrize("name", layers.names())
def test_a_layer_says_what_it_is(name):
    layer = layers.get(name)
    assert layer.name == name and layer.summary
    assert len(layer.coded_as()) == max(len(layer.formats), 1)
    assert layer.drawn_by in ("", *parts.names())
    assert set(layer.formats) <= set(PIXEL_BYTES)
    sizes = EyeSizes((7, 5), (4, 3), (FOV,))
    expected = {RENDERED: sizes.rendered, SHOWN: sizes.shown, OWN: layer.size(sizes)}
    assert layer.size(sizes) == expected[layer.size_class]
    assert (layer.size_class == OWN) == (layer.size.__func__ is not Layer.size.__func__)


def test_every_layer_is_read_by_some_pass():
    """By default, or with one of a warp's settings that is a word; but for what lights pictures."""
    readers = [*warps, *fills, *(effect.made_by for effect in effects), ExpandPass]
    read = {name for reader in readers for name in reader.reads}
    for warp in warps:
        for field in attrs.fields(warp.Settings):
            for word in typing.get_args(typing.get_type_hints(warp.Settings)[field.name]):
                read |= {*warp.reads_for(warp.Settings(**{field.name: word}))}
    assert {name for name in read if name.startswith("rendered.")} == {
        layer.readable() for layer in layers if not layer.lights
    }


def test_needs_add_up():
    one, other = Needs(peeled=1, cube=True, others=Others(2, 50)), Needs(peeled=3, others=Others(1, 40, True))
    both = one | other
    assert both == other | one == both | both == Needs(peeled=3, cube=True, others=Others(2, 40, True))
    assert one | Needs() == one
    mirrors = Needs(reflection=Mirrored.PLANE) | Needs(reflection=Mirrored.CURVED)
    assert mirrors == Needs(reflection=Mirrored.PLANE | Mirrored.CURVED)
    # Older frames that are not kept have no spacing.
    assert (Needs(others=Others(0, 0, True)) | Needs(others=Others(1, 50))).others == Others(1, 50, True)
    assert Needs(cube=False, peeled=0, others=Others()) == Needs() == {} and "cube" not in Needs(cube=False)
    assert hash(Needs(cube=True, ids=False)) == hash(Needs(cube=True))
    assert repr(Needs(peeled=2, cube=True)) == "Needs(cube=True, peeled=2)"
    with pytest.raises(UnknownNameError, match="did you mean 'cube'"):
        Needs(cubes=True)


TWO = Others(2, 50)


@pytest.mark.parametrize(
    ("carried", "needed", "enough"),
    [
        ({}, {}, True), ({"peeled": 2}, {"peeled": 2}, True), ({"peeled": 2}, {"peeled": 1}, False),
        ({"cube": True}, {}, False), ({}, {"cube": True}, False), ({"others": Others(2, 50, True)}, {}, True),
        ({"others": Others(2, 50, True)}, {"others": Others(1, 50)}, True),
        ({"others": TWO}, {"others": Others(1, 40)}, False), ({"others": Others(1, 50)}, {"others": TWO}, False),
        ({"others": TWO}, {"others": Others(0, 0, True)}, False), ({}, {"others": Others(1, 50)}, False),
    ],
)  # fmt: skip
def test_a_plan_runs_on_frames_that_carry_the_same(carried, needed, enough):
    """More or fewer layers are other frames; more older frames than needed disturb nobody."""
    assert Needs(**carried).serve(Needs(**needed)) == enough


def test_an_image_is_cut_to_what_a_plan_needs_and_is_the_same_where_nothing_is_cut():
    surfaces = (Surface(None, None), Surface(None, None))
    image = EyeImage(None, None, None, {"peeled": surfaces, "cube": "cube"})
    assert image.only(Needs()).carried == {}
    assert image.only(Needs(peeled=1, cube=True)).carried == {"peeled": surfaces[:1], "cube": "cube"}
    assert image.only(Needs(peeled=2, cube=True, overlay=True)) is image


SIZES = [0, 1, FRAGMENT_BYTES, FRAGMENT_BYTES + 1, 7 * FRAGMENT_BYTES + 3]


def things_of(sizes: list[int]) -> list[bytes]:
    rng = np.random.default_rng(1)
    return [rng.bytes(size) for size in sizes]


@settings(max_examples=60)
@given(
    st.lists(st.sampled_from(SIZES), max_size=6),
    st.integers(1, 6 * FRAGMENT_BYTES),
    st.lists(st.booleans(), max_size=60),
    st.integers(1, 9),
    st.randoms(use_true_random=False),
)
def test_all_arrives_whatever_is_lost_late_or_out_of_order(sizes, budget, lost, round_trip, random):
    things = things_of(sizes)
    outbox, inbox, got, flying = Outbox(things), Inbox(), {}, []
    fates = iter(lost)
    for now in range(2000):
        outbox.settle(now)
        update = outbox.update(range(len(things)), budget, now)
        assert len(update.content) <= max(budget, FRAGMENT_BYTES + 20)
        arrives = not next(fates, False)
        outbox.heard(update, arrives, now + round_trip)
        flying += [update] if arrives else []
        random.shuffle(flying)
        if now % 3 == 0:
            for message in flying:
                got |= dict(inbox.take(message.content))
            flying = []
        if len(got) == len(things):
            break
    assert got == dict(enumerate(things))
    assert inbox.whole == len(things)


def test_only_lost_updates_are_sent_twice():
    things = things_of([5 * FRAGMENT_BYTES])
    outbox = Outbox(things)
    sent = [outbox.update([0, 0], 2 * (FRAGMENT_BYTES + 14), now) for now in range(3)]
    assert [len(delivery.pieces) for delivery in sent] == [2, 2, 1]
    assert not outbox.waiting and not outbox.update([0], 10_000, 3).pieces
    outbox.heard(sent[1], False, 10)
    outbox.heard(sent[0], True, 9)
    outbox.settle(8)
    assert not outbox.waiting and outbox.round_trip_ns is None
    outbox.settle(10)
    assert outbox.waiting == {0} and outbox.round_trip_ns == 9
    assert outbox.update([0], 10_000, 11).pieces == sent[1].pieces


def test_a_repeated_update_changes_nothing_and_takes_no_memory():
    outbox, inbox = Outbox(things_of([3 * FRAGMENT_BYTES])), Inbox()
    update = outbox.update([0], 10_000, 0)
    assert len(list(inbox.take(update.content))) == 1
    for _ in range(3):
        assert not list(inbox.take(update.content))
    assert inbox._begun == {} and inbox.bytes == 4 * len(update.content)
    update.content[...] = update.content.copy()  # the link writes over it
    assert len(outbox.update([], 100, 0).content) == len(Outbox([]).update([], 100, 0).content) == 0
