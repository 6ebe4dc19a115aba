"""Further layers of the feed: each comes back as it was drawn, motion vectors as velocities."""

import math
from contextlib import closing

import attrs
import numpy as np
import pytest

from hmdwarp.base import InputError
from hmdwarp.frames import EyeImage, Frame, Needs
from hmdwarp.frames.layers import layers
from hmdwarp.geometry import Fov, Mirror, Pose, RigidState, View
from hmdwarp.gpu import download, upload
from hmdwarp.pipeline.feed_coding import made, misfit, needs_of_client, parts_of, unpacked, velocity_of, wanted_of
from hmdwarp.scenes import load_scene
from hmdwarp.sources.feed.message import FrameMessage, decode, encode
from hmdwarp.sources.feed.parts import Packed, Wanted
from hmdwarp.sources.server import Server

from .exchange import FRAME, vector_row

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
    parts = [part for of_eye in arrived.layers for several in of_eye.values() for part in several]
    assert (packs and is_something) == any(isinstance(part, Packed) for part in parts)
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


WIDE, HIGH, SECONDS = 40, 30, 1 / 90
NOW = View(Pose((0.3, 1.6, -2.0), (0.05, -0.1, 0.02, 0.99)), Fov(-0.7, 0.8, -0.75, 0.6))
BEFORE = View(Pose((0.29, 1.61, -1.98), (0.04, -0.12, 0.03, 0.99)), Fov(-0.72, 0.78, -0.75, 0.62), Pose((0.03, 0, 0)))
RANGES = [(0.1, 100.0), (100.0, 0.1), (0.1, np.inf), (np.inf, 0.1)]


def clip_from_world(view: View, near: float, far: float) -> np.ndarray:
    """Vulkan's: y down, z 0 at near and 1 at far."""
    left, right, down, up = np.tan([view.fov.left, view.fov.right, view.fov.down, view.fov.up])
    at, of = 1 / near, 1 / far
    # z' / w with w = -z: (1 / w - at) / (of - at).
    rows = [[2 / (right - left), 0, (right + left) / (right - left), 0]]
    rows += [[0, -2 / (up - down), -(up + down) / (up - down), 0]]
    rows += [[0, 0, at / (of - at), 1 / (of - at)], [0, 0, -1, 0]]
    eye = np.eye(4)
    eye[:3, :3], eye[:3, 3] = view.pose.rotation.as_matrix(), view.pose.position_m
    return np.array(rows) @ np.linalg.inv(eye)


def ndc(view: View, points: np.ndarray, near: float, far: float) -> np.ndarray:
    clip = np.concatenate([points, np.ones((*points.shape[:2], 1))], axis=2) @ clip_from_world(view, near, far).T
    return clip[..., :3] / clip[..., 3:]


def turned(rotation, vectors: np.ndarray) -> np.ndarray:
    return rotation.apply(vectors.reshape(-1, 3)).reshape(vectors.shape)


def moving(near: float, far: float, *, across: bool = False) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Inverse depth, velocity in the world (left half moves, top row is sky), and vectors. across:
    of the view before, and vectors without depth."""
    rng = np.random.default_rng(5)
    depth, velocity = 1 / rng.uniform(1, 6, (HIGH, WIDE)), rng.uniform(-1, 1, (HIGH, WIDE, 3))
    velocity[:, WIDE // 2 :] = 0
    if across:
        velocity = turned(BEFORE.pose.rotation, turned(BEFORE.pose.rotation.inv(), velocity) * (1, 1, 0))
    left, right, down, up = NOW.fov.tangents
    x, y = ((np.arange(n) + 0.5) / n for n in (WIDE, HIGH))
    rays = np.stack([*np.meshgrid(left + (right - left) * x, up + (down - up) * y), np.full((HIGH, WIDE), -1.0)], -1)
    points = NOW.pose.position_m + turned(NOW.pose.rotation, rays / depth[..., None])
    vectors = ndc(NOW, points, near, far) - ndc(BEFORE, points - SECONDS * velocity, near, far)
    depth[0], velocity[0] = 0, 0
    return depth, velocity, vectors * (1, 1, not across)


def told(near: float, far: float, *coded, before: View = BEFORE) -> np.ndarray:
    return vector_row(before, near, far, *coded, seconds=SECONDS)


def picture(vectors: np.ndarray) -> np.ndarray:
    return np.concatenate([vectors, np.zeros((*vectors.shape[:2], 1))], axis=2)


@pytest.mark.parametrize("coded", [((1, 1, 1), (0, 0, 0)), ((2, -1, 1), (0.5, 0, 0))], ids=["plain", "as of OpenGL"])
@pytest.mark.parametrize(("near", "far"), [*RANGES, (0, 0)])
def test_exact_vectors_give_exact_velocities(near, far, coded):
    """Those of two numbers, told by 0 and 0, keep the depth: what moves along is missed."""
    depth, velocity, vectors = moving(near or 0.1, far or 100.0, across=far == 0)
    scale, offset = coded
    found = velocity_of((picture((vectors - offset) / scale), told(near, far, *coded)), NOW, depth)
    np.testing.assert_array_equal(found[..., 3], (velocity != 0).any(axis=2))
    # Rounded to halves once: 2^-11 of at most 2 m/s.
    np.testing.assert_allclose(found[..., :3], turned(NOW.pose.rotation.inv(), velocity), atol=2 * 2.0**-11)


# In the middle, and all that the last row or column of vectors tells.
@pytest.mark.parametrize(("top", "end", "left", "right"), [(11, 23, 9, 25), (HIGH - 1, HIGH, 9, 25), (11, 23, 39, 40)])
def test_vectors_of_lower_resolution_go_to_the_surface_that_they_are_of(top, end, left, right):
    """A near square moves before a far wall: its edge stays where the picture's depth has it."""
    depth, moves = np.full((HIGH, WIDE), 0.1), np.zeros((HIGH, WIDE), bool)
    moves[top:end, left:right] = True
    depth[moves] = 0.5
    low = (HIGH // 2, WIDE // 2)
    vectors = np.zeros((*low, 3))
    # Of each low pixel the centre lies in the pixel right of and below its middle.
    vectors[moves[1::2, 1::2]] = (0.01, 0, 0)
    still = told(0.1, np.inf, before=attrs.evolve(NOW, head_from_eye=Pose()))
    found = velocity_of((picture(vectors), still), NOW, depth)
    np.testing.assert_array_equal(found[..., 3] == 1, moves)
    # Across by 0.01 of half the field, at the depth of the surface, which its vector's pixel has.
    field = np.tan(NOW.fov.right) - np.tan(NOW.fov.left)
    expected = 0.01 * field / 2 / 0.5 / SECONDS
    np.testing.assert_allclose(found[moves][:, 0], expected, rtol=2.0**-10)


@pytest.mark.parametrize(
    "change",
    [
        (8, 0.0), (8, -1.0), (8, np.nan), (6, -0.1), (6, 0.0), (6, 100.0), (7, np.nan), (0, np.inf), (23, 3.0),
        (12, np.nan),
    ],
)  # fmt: skip
def test_numbers_that_are_none_are_refused(change):
    depth, _, vectors = moving(0.1, 100.0)
    numbers = told(0.1, 100.0)
    numbers[0, change[0]] = change[1]
    with pytest.raises(InputError):
        velocity_of((picture(vectors), numbers), NOW, depth)
    for parts in ((picture(vectors),), (picture(vectors)[..., 0], told(0.1, 1)), (picture(vectors), np.zeros((1, 4)))):
        with pytest.raises(InputError):
            velocity_of(parts, NOW, depth)
    # But vectors may be anything.
    wild, rng = picture(vectors), np.random.default_rng(1)
    wild[rng.random(wild.shape) < 0.3] = rng.choice([np.nan, np.inf, -np.inf, 6e4, -6e4])
    assert np.isfinite(velocity_of((wild, told(0.1, 100.0)), NOW, depth)).all()
