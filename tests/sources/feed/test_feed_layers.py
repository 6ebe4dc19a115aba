"""Further layers of the feed: each comes back as it was drawn, and what is none is refused."""

import math
import random
from collections import Counter
from contextlib import closing

import attrs
import numpy as np
import pytest

from hmdwarp.errors import InputError
from hmdwarp.frames import EyeImage, Frame, Needs
from hmdwarp.frames.layers import layers
from hmdwarp.geometry import Fov, Mirror, Pose, RigidState, View
from hmdwarp.gpu import download, upload
from hmdwarp.link.codec import Undecodable
from hmdwarp.pipeline.feed_layers import made, misfit, needs_of_client, parts_of, unpacked, wanted_of
from hmdwarp.scenes import load_scene
from hmdwarp.sources.feed.message import FrameMessage, Malformed, decode, encode
from hmdwarp.sources.feed.parts import Packed, Wanted, packed
from hmdwarp.sources.server import Server

from .messages import FRAME
from .test_motion_vectors import told

SIZE, SHOWN = (24, 20), (16, 12)
DRAWN_NS = 70_000_000
VIEWS = [View(Pose((x, 1.6, 1.0)), Fov.symmetric(1.0, 0.8)) for x in (-0.03, 0.03)]
FED = [layer.name for layer in layers if not (layer.of_client or layer.always)]
TURNED = Pose((1, 2, 3), (0.1, 0.2, 0.3, 0.9))
MIRRORS = (Mirror((0, 1, 2), (1, 0, 0), (0, 1, 0), 0.0, 0.3), Mirror((4, 5, 6), radius_m=1.5))


@pytest.fixture
def server(gpu):
    with closing(Server(gpu, load_scene("planes"))) as one:
        yield one


def drawn(server: Server, name: str) -> tuple[Wanted, list[EyeImage]]:
    """Eyes with random content of one layer, and the wish for it."""
    rng = np.random.default_rng(19)
    needs = Needs(**{name: layers.get(name).something})
    wanted = wanted_of(needs, VIEWS, SHOWN)
    assert needs_of_client(wanted) == needs
    frame = server.draw_guarded(VIEWS, DRAWN_NS, SIZE, needs, wanted.fovs, SHOWN)
    eyes = []
    for eye in frame.eyes:
        for texture in layers.get(name).sent(eye[name]):
            if isinstance(texture, np.ndarray):
                if name != "panels":  # whose bytes are checked: here that there are none
                    texture[...] = rng.integers(0, 256, texture.shape)
                continue
            numbers = download(texture)
            is_index = numbers.dtype == np.uint16
            upload(texture, rng.integers(0, 3, numbers.shape) if is_index else rng.random(numbers.shape))
        data = eye[name]
        if name == "ids":
            moving = RigidState(TURNED, (1, 0, 0), (0, 2, 0), (0, 0, -9.81))
            data = attrs.evolve(data, bodies=(moving, RigidState(Pose())))
        if name == "reflection":
            data = attrs.evolve(data, mirrors=MIRRORS)
        eyes.append(eye.having(**{name: data}))
    return wanted, eyes


def message(eyes: list[EyeImage], needs: Needs, *, packs: bool) -> FrameMessage:
    """The frame of these eyes, as it arrives."""
    pictures = [(download(eye.colour), download(eye.inverse_depth)) for eye in eyes]
    further = parts_of(Frame(tuple(eyes), 0), needs, packs=packs)
    colours, depths = (tuple(of_eye) for of_eye in zip(*pictures, strict=True))
    sent = attrs.evolve(
        FRAME, views=tuple(eye.view for eye in eyes), colours=colours, inverse_depths=depths, layers=further
    )
    found = decode(encode(sent))
    assert isinstance(found, FrameMessage)
    return found


@pytest.mark.parametrize("packs", [False, True])
@pytest.mark.parametrize("name", FED)
def test_a_layer_arrives_as_it_was_drawn(server, name, packs):
    layer, (wanted, eyes) = layers.get(name), drawn(server, name)
    arrived = message(eyes, needs_of_client(wanted), packs=packs)
    is_something = bool([*layer.sent(eyes[0][name])])
    assert eyes[0].size == SIZE and (name != "overlay" or eyes[0][name].size == SHOWN)
    assert (packs and is_something) == any(isinstance(part, Packed) for part in arrived.further)
    found = unpacked(arrived)
    assert misfit(found, wanted) == ""
    bare = [attrs.evolve(eye, carried={}) for eye in eyes]
    for eye, back in zip(eyes, made(server, bare, found.layers, wanted), strict=True):
        data = back[name]
        for ours, theirs in zip(layer.sent(eye[name]), layer.sent(data), strict=True):
            np.testing.assert_array_equal(numbers_of(ours), numbers_of(theirs))
        if not is_something:
            assert data == eye[name]
        if name in ("views", "wide"):
            assert layer.numbers(data).tobytes() == layer.numbers(eye[name]).tobytes()
            assert {one.drawn_ns for one in (data if name == "views" else [data])} == {DRAWN_NS}
        if name == "ids":
            assert [str(body) for body in data.bodies] == [str(body) for body in eye[name].bodies]
        if name == "reflection":
            assert [str(mirror) for mirror in data.mirrors] == [str(mirror) for mirror in MIRRORS]


def numbers_of(sent) -> np.ndarray:
    return sent if isinstance(sent, np.ndarray) else download(sent)


def test_layers_that_frames_cannot_carry_are_refused():
    for name in ("others", "colour", "nothing_such"):
        with pytest.raises(InputError, match=name):
            needs_of_client(Wanted(((name, 1),), SHOWN, ()))
    for name, stated in [
        ("reflection", 99),
        ("views", 13),
        ("points", 1),
        ("points", ((1.0,),)),
        ("points", ((1e99, 1024, 1),)),
        ("photons", ((60_000, math.nan, 1),)),
        ("voxels", ((8, 4, 4, 10), (8, 5, 4, 10))),
        ("scene_update", ((0.5, 0.5, 0.5, 100),)),
        ("irradiance", 3),
        ("cube", ((1.0,),)),
    ]:
        with pytest.raises(InputError, match=name):
            needs_of_client(Wanted(((name, stated),), SHOWN, ()))


@pytest.mark.parametrize(
    ("name", "change", "expected"),
    [
        ("velocity", lambda parts: None, "sends no layer 'velocity'"),
        ("velocity", lambda parts: [parts[0][:-1]], "shape"),
        ("velocity", lambda parts: [parts[0].astype(np.float32)[..., 0]], "float32"),
        ("peeled", lambda parts: parts[:2], "2 parts"),
        ("peeled", lambda parts: [*parts, np.zeros((1, 2))], "expected none"),
        ("ids", lambda parts: parts[:1], "bodies are missing"),
        ("ids", lambda parts: [parts[0], parts[1][:0]], "there are 0 bodies"),
        ("ids", lambda parts: [parts[0], np.full_like(parts[1], np.nan)], "1e+06 at most"),
        ("ids", lambda parts: [parts[0], 1e7 * parts[1]], "1e+06 at most"),
        ("ids", lambda parts: [parts[0], 0 * parts[1]], "quaternion"),
        ("reflection", lambda parts: [*parts[:3], parts[3][:, :-1]], "mirrors are missing"),
        ("reflection", lambda parts: [*parts[:3], 0 * parts[3]], "without an area"),
        ("reflection", lambda parts: [*parts[:3], 4 * parts[3]], "more than all"),
    ],
)
def test_parts_that_do_not_fit_their_declaration_are_refused(server, name, change, expected):
    wanted, eyes = drawn(server, name)
    frame = unpacked(message(eyes, needs_of_client(wanted), packs=False))
    changed = [(one, change(of_eye[name])) for one, of_eye in enumerate(frame.layers)]
    further = tuple({} if parts is None else {name: parts} for _, parts in changed)
    assert expected in misfit(attrs.evolve(frame, layers=further), wanted)


def test_a_frame_with_a_damaged_part_is_undecodable(server):
    wanted, eyes = drawn(server, "velocity")
    frame = message(eyes, needs_of_client(wanted), packs=True)
    (part,) = frame.layers[0]["velocity"]
    broken = attrs.evolve(part, data=part.data[:-3])
    with pytest.raises(Undecodable, match="packed"):
        unpacked(attrs.evolve(frame, layers=({"velocity": [broken]}, frame.layers[1])))


def test_broken_frames_are_taken_or_refused():
    """No bytes do more than that, and what is taken has the shapes that are uploaded."""
    rng = random.Random(19)
    wanted = Wanted((("velocity", 1), ("ids", 1), ("peeled", 1)), (4, 3), tuple(view.fov for view in VIEWS))
    vectors = [np.ones((2, 3, 4), np.float16), told(0.1, 9.0)]
    ids = [np.ones((3, 4), np.uint16), np.eye(1, 16, 6)]
    peeled = [packed(np.ones((3, 4, 4), np.float16)), packed(np.ones((3, 4), np.float32))]
    of_eye = {"velocity": vectors, "ids": ids, "peeled": peeled}
    sent = attrs.evolve(FRAME, layers=(of_eye, of_eye))
    assert misfit(unpacked(decode(encode(sent))), wanted) == ""
    # From the heads of the parts on.
    whole, counts = encode(sent), Counter()
    at = whole.index(b"velocity")
    for _ in range(2000):
        data = bytearray(whole)
        for _ in range(rng.randint(1, 3)):
            data[rng.randrange(at, len(data))] = rng.choice((0, 1, 127, 255, rng.randrange(256)))
        try:
            wrong = misfit(unpacked(decode(bytes(data))), wanted)
        except (Malformed, Undecodable) as error:
            wrong = type(error).__name__
        counts[wrong.split(" of ")[0]] += 1
    assert min(counts[""], counts["Malformed"], counts["Undecodable"]) > 100 and len(counts) > 5
