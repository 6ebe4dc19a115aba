"""Points: on the client, in the books of both sides of a link, and lit as their surfaces are."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from client_scene import ClientScene
from lit_rooms import plain
from worlds import shown_by

from hmdwarp.base import linear_from_srgb
from hmdwarp.client import PassInputs
from hmdwarp.client.warps import Output
from hmdwarp.cloudlight.photons import octahedral
from hmdwarp.cloudlight.points import (
    LEAST_BUDGET,
    PAGE,
    Block,
    Cloud,
    KeptPoints,
    PointCells,
    PointRoom,
    PointSender,
    block_range,
    packed_sky,
    unpacked,
)
from hmdwarp.cloudlight.radiosity import direct_light, transport_of
from hmdwarp.frames import EyeImage
from hmdwarp.frames.layers import Update
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import COLOUR, SCALAR, allocate
from hmdwarp.scenes import lamps_at, load_scene

SIZE, FOV = (64, 48), Fov(-0.5, 0.5, -0.4, 0.4)
EYE = View(Pose((0.3, -0.1, 0.2), (0.02, 0.05, 0.0, 0.998)), FOV)
SKY = np.array([[0.25, 0.5, 1.0], [0.5, 0.5, 0.5], [0.125, 0.25, 0.125]])
COUNT = 4096


def content(points: np.ndarray, normals: np.ndarray, area: float, *, complete: bool = True) -> np.ndarray:
    """An update with these points in one cell, in blocks of 128."""
    low = points.min(axis=0).astype(np.float32).astype(float)
    edge = float(np.float32(max((points - low).max(), 1e-3)))
    steps = np.rint((points - low) / edge * 1023).clip(0, 1023).astype(np.uint32)
    packed = steps[:, 0] | steps[:, 1] << 10 | steps[:, 2] << 20
    colours = np.full((len(points), 3), (255, 128, 0), np.uint8)
    data = packed_sky(SKY, complete=complete)
    for number, at in enumerate(range(0, len(points), 128)):
        part = slice(at, at + 128)
        place = (float(low[0]), float(low[1]), float(low[2]))
        one = Block(0, 0, number, 0, False, place, edge, area, packed[part], octahedral(normals[part]), colours[part])
        data += one.packed()
    return np.frombuffer(data, np.uint8).copy()


def sphere(centre: tuple[float, float, float], radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Points on a sphere by the golden angle."""
    k = np.arange(COUNT) + 0.5
    z, angle = 1 - 2 * k / COUNT, np.pi * (1 + 5**0.5) * k
    normals = np.column_stack([np.sqrt(1 - z * z) * np.cos(angle), np.sqrt(1 - z * z) * np.sin(angle), z])
    return np.array(centre) + radius * normals, normals


def shown(gpu, update: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Colour and inverse depth, the same twice."""
    geometry = ClientScene(gpu)
    geometry.store(KeptPoints, Cloud()).receive(update)
    frame = EyeImage(EYE, allocate(gpu.gl, SIZE, COLOUR), allocate(gpu.gl, SIZE, SCALAR))
    inputs = PassInputs(frame, EYE)
    pictures = [shown_by(gpu, "points", inputs, SIZE, Output(depth=True), geometry) for _ in range(2)]
    assert all(np.array_equal(one, other) for one, other in zip(*pictures, strict=True))
    assert all(np.isfinite(picture).all() for picture in pictures[0])
    return pictures[0]


def test_a_sphere_of_points_is_the_sphere(gpu):
    """Discs lie behind the sphere by at most their sagitta and their tilt, where it is met steeply.

    Area 4 pi r^2 over 4096 points: discs of 1.1 sqrt(area / 4096) = 0.061 m, so the sagitta is 1.9
    mm; tilted by 0.7 degrees they are off by 0.7 mm; steps of position are 2 m / 2046 at most. Met
    at 45 degrees that is 1.5 times as much along the ray: 6 mm of 3 m.
    """
    centre, radius = np.array((0.1, 0.0, -3.0)), 1.0
    colour, depth = shown(gpu, content(*sphere(tuple(centre), radius), 4 * np.pi * radius**2))
    left, right, down, up = FOV.tangents
    x = left + (np.arange(SIZE[0]) + 0.5) / SIZE[0] * (right - left)
    y = down + (np.arange(SIZE[1]) + 0.5) / SIZE[1] * (up - down)
    rays = np.stack([*np.meshgrid(x, y), np.full(SIZE[::-1], -1.0)], axis=2) @ EYE.pose.rotation_matrix.T
    off = centre - EYE.pose.position_m
    a, b, c = (rays**2).sum(axis=2), rays @ off, off @ off - radius**2
    root = b * b - a * c
    at = (b - np.sqrt(np.maximum(root, 0))) / a
    normal = (rays * at[..., None] - off) / radius
    steep = (root > 0) & (-(normal * rays).sum(axis=2) / np.sqrt(a) > 0.7)
    assert steep.sum() > 300
    assert np.abs(1 / depth[steep] - at[steep]).max() < 0.006
    assert (colour[steep, 3] == 1).all() and np.abs(colour[steep, 1] - 0.2159).max() < 1e-3
    beside = root < -2
    assert (depth[beside] == 0).all() and (colour[beside, 3] == 1).all(), "the sky"


HARD = {  # a point and the area of its disc
    "far": ((0.0, 0.0, -1e6), 1.0), "radius 0": ((0.0, 0.0, -2.0), 0.0), "in the eye": ((0.3, -0.1, 0.2), 1.0),
    "behind the eye": ((0.3, -0.1, 2.0), 1.0), "beyond": ((0.0, 0.0, -1e30), 1e30),
}  # fmt: skip


@pytest.mark.parametrize("case", HARD)
def test_hard_points(gpu, case):
    point, area = HARD[case]
    colour, depth = shown(gpu, content(np.tile(point, (16, 1)), np.tile((0.0, 0.0, 1.0), (16, 1)), area))
    if case in ("far", "radius 0"):
        assert (depth > 0).sum() == 1 and colour[depth > 0, 0] == 1
    if case == "behind the eye":
        assert (depth == 0).all(), "sky alone"


# --- the books of both sides: nothing lost for good, nothing doubled ------------------------------


NUMBERED = np.arange(9.0).reshape(3, 3)


def block_of(cell: int, age: int, number: int) -> Block:
    count = block_range(number)[1] if number >= 0 else 0
    rng = np.random.default_rng(cell + 100 * max(number, 0))
    arrays = (rng.integers(0, 1 << 30, count, np.uint32), *(rng.integers(0, 256, (count, k), np.uint8) for k in (2, 3)))
    return Block(cell, age, number, 2, True, (1.0, -2.0, 1e6), 0.5, 0.25, *arrays)


class Client:
    """A room that knows what each page holds."""

    def __init__(self, room: int) -> None:
        self.pages: dict[int, tuple[int, int]] = {}
        self.room = PointRoom(room, self.write, self.clear)

    def write(self, block: Block, slot: int, pages: list[int], points: int) -> None:
        assert not self.pages.keys() & set(pages)
        self.pages |= dict.fromkeys(pages, (block.cell, block.number))

    def clear(self, pages: list[int]) -> None:
        for page in pages:
            del self.pages[page]

    def take(self, update: Update) -> None:
        for block in unpacked(update.content)[2]:
            self.room.take(block)


def update_of(sent: list, now_ns: int) -> Update:
    data = packed_sky(NUMBERED, complete=False) + b"".join(block_of(*block).packed() for block in sent)
    return Update(np.frombuffer(data, np.uint8).copy(), tuple(sent), now_ns)


def test_blocks_follow_each_other_in_whole_pages():
    at = 0
    for number in range(40):
        first, count = block_range(number)
        assert first == at and count % PAGE == 0
        assert len(block_of(0, 0, number).packed()) < LEAST_BUDGET - len(packed_sky(NUMBERED, complete=True))
        at += count


def test_packing_is_reversible():
    wanted = [block_of(7, 3, 5), block_of(8, 65535, -1)]
    data = np.frombuffer(packed_sky(NUMBERED, complete=True) + b"".join(block.packed() for block in wanted), np.uint8)
    complete, sky, got = unpacked(data)
    assert complete and np.array_equal(sky, NUMBERED)
    for one, other in zip(got, wanted, strict=True):
        assert (one.cell, one.age, one.low, one.edge, one.area) == (
            other.cell, other.age, other.low, other.edge, other.area,
        )  # fmt: skip
        assert one.body == 2 and one.double_sided
        for name in ("positions", "normals", "colours"):
            assert np.array_equal(getattr(one, name), getattr(other, name))


def test_ten_minutes_of_loss_and_disorder_stay_within_bounds():
    """At 60 frames a second: a head wanders over 200 cells; the room holds a third."""
    rng, room, cells, frames = np.random.default_rng(0), 64 * 128, 200, 36_000
    book, client = PointSender(cells, room), Client(room)
    flying: list[tuple[int, Update]] = []
    most = 0
    for now in range(frames):
        book.settle(now)
        here = int(60 * (1 + np.sin(now / 500))) % cells
        wanted = range(here, min(here + 40, cells))
        if now > frames - 400:  # it stands still, and nothing is lost
            wanted = range(20, 60)
        sent = book.forgetting(20)
        for cell in wanted:
            if len(sent) >= 8:
                break
            if book.points[cell] < 128:
                if block_range(book.next_block(cell))[1] > book.free:
                    gone = [k for k in np.flatnonzero(book.points) if k not in wanted]
                    for k in gone[:5]:
                        book.forget(int(k))
                    break
                sent.append(book.sent(cell))
        update = update_of(sent, now)
        arrives = rng.random() > 0.2 or now > frames - 400
        due = now + int(rng.integers(1, 40))
        book.heard(update, arrives, due + 5)
        if arrives:
            flying.append((due, update))
        for due in [message for message in flying if message[0] <= now]:
            client.take(due[1])
        flying = [message for message in flying if message[0] > now]
        assert client.room.points <= room and len(client.pages) <= room // PAGE
        most = max(most, book.remembered)
    # Two frames of 28 things for each of the 45 frames before the news returns, and each cell's.
    assert most < 45 * 28 + 8 * cells
    pages = Counter(client.pages.values())
    assert all(count * PAGE == block_range(number)[1] for (_, number), count in pages.items()), "none is doubled"
    held = set(pages)
    for cell in range(20, 60):
        assert {number for of, number in held if of == cell} >= set(range(4)), "all that was wanted has arrived"


# --- the light of each point ----------------------------------------------------------------------


@pytest.mark.parametrize("name", ["lantern", "sunroom", "doorway"])
def test_points_have_the_light_of_the_start(name):
    """Light at corners 25 cm apart is blended: half of all points lie where it is smooth within a
    tenth. Nearly none has the bare albedo, which is what points had before."""
    scene = plain(load_scene(name))
    cells, transport = PointCells(scene), transport_of(scene)
    lamps = lamps_at(scene, 0)
    atlas = transport.indirect(transport.direct(lamps))
    errors = []
    for cell in range(0, cells.count, 7):
        found = cells.block((cell, 0, 0), 0.01)
        steps = np.stack([found.positions >> (10 * k) & 1023 for k in range(3)], axis=1) / 1023
        places, body = cells.low[cell] + cells.edge[cell] * steps, cells.body[cell]
        facing = np.tile(cells.facing[cell], (len(places), 1))
        if body:
            pose = scene.bodies[body - 1].motion.state(0).pose
            places, facing = pose.transform(places), pose.rotation.apply(facing)
        near = ((transport.patches.centres - places[:, None]) ** 2).sum(axis=2)
        near += 1e3 * (transport.patches.normals @ facing.T < 0.99).T
        patch = near.argmin(axis=1)
        light = direct_light(transport.blockers, places + 2e-3 * facing, facing, lamps) + atlas[patch]
        wanted = np.minimum(transport.patches.albedo[patch] * light, 1)
        errors.append(
            np.abs(linear_from_srgb(found.colours) - wanted).mean(axis=1) / np.maximum(wanted.mean(axis=1), 0.01)
        )
    assert np.median(np.concatenate(errors)) < 0.1
