"""The memory.

What was seen before comes back, what moved is forgotten, and it stays within its bounds.
"""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from golden_pictures import assert_golden, sheet
from holed import Holed
from scipy.spatial.transform import Rotation
from worlds import World, read

from client.test_multi import BEFORE_A_WALL, HALF_FLOAT, WALL, at, drawn, scene_of, square
from hmdwarp.base import InputError
from hmdwarp.client import PassInputs, ShownPicture, parse_fills
from hmdwarp.client.fills.memory import (
    HoleFiller,
    Keeper,
    Keyframe,
    Slot,
    covered,
    is_new,
    most_redundant,
    most_useful,
    seeds_for,
)
from hmdwarp.frames import BodyIds, EyeImage
from hmdwarp.geometry import Pose, View
from hmdwarp.gpu import COLOUR, NUMBER, SCALAR, Canvas, allocate

SIZE = (120, 96)


class Client:
    """A memory and an empty shown picture: what it fills is what it knows."""

    def __init__(self, gpu, spec: str = "memory", size=SIZE) -> None:
        (choice,) = parse_fills(spec)
        self.gpu, self.fill = gpu, choice.entry(gpu, size, size, choice.settings)
        self.empty, self.into = (ShownPicture(Canvas(gpu.gl, size), allocate(gpu.gl, size, SCALAR)) for _ in range(2))
        self.empty.colour.clear()
        self.empty.inverse_depth.write(np.full(size[::-1], -1, np.float32).tobytes(), alignment=1)

    def sees(self, rendered: EyeImage, shown: View, eye: int = 0) -> np.ndarray:
        """Colour and coverage after one refresh."""
        self.fill.run(PassInputs(rendered, shown, eye), self.empty, self.into)
        self.gpu.gl.memory_barrier()
        return read(self.into.colour.texture)

    def depth(self) -> np.ndarray:
        return read(self.into.inverse_depth)[..., 0]

    def close(self) -> None:
        self.fill.close()


@pytest.fixture
def client(gpu):
    made = Client(gpu)
    yield made
    made.close()


def seconds(image: EyeImage, s: float) -> EyeImage:
    return attrs.evolve(image, drawn_ns=round(s * 1e9))


def turned(degrees: float, x: float = 0) -> View:
    """To the left."""
    return View(Pose((x, 0, 0), Rotation.from_euler("y", degrees, degrees=True).as_quat()), at(0).fov)


def test_scenery_that_was_seen_comes_back(gpu, client):
    """The head looks left, right and left again.

    At the last look the rendered picture still shows the right.
    """
    scene = scene_of(square(2, (-1.5, 0.2), 0.5, 0.5), WALL)
    left, right = (drawn(gpu, scene, turned(angle)) for angle in (0, -50))
    client.sees(seconds(left, 0), left.view)
    alone = Client(gpu)
    without, with_memory = (tried.sees(seconds(right, 1), turned(0)) for tried in (alone, client))
    alone.close()
    truth = read(drawn(gpu, scene, turned(0)).colour)
    assert (without[..., 3] == 0).mean() > 0.3
    assert (with_memory[..., 3] == 0).mean() < 0.01
    assert (np.abs(with_memory - truth).max(axis=-1) > HALF_FLOAT).mean() < 0.03, (
        "all but outlines, which are half a pixel off"
    )


def test_a_thing_that_left_is_forgotten_once_a_newer_frame_sees_through_its_place(gpu, client):
    """A square before the wall is seen, goes while it is looked at, and is not put back when the
    head has turned away from it.
    """
    with_it, without = drawn(gpu, BEFORE_A_WALL, turned(0)), drawn(gpu, scene_of(WALL), turned(0))
    away = drawn(gpu, scene_of(WALL), turned(-60))
    client.sees(seconds(with_it, 0), turned(0))
    remembered = client.sees(seconds(away, 0.1), turned(0))
    assert np.abs(remembered[..., 0] - 0.5).min() <= HALF_FLOAT, "the square is remembered as long as nobody looks"
    for k in range(2):  # each is held against one of the two that are kept
        client.sees(seconds(without, 0.2 + 0.01 * k), turned(0))
    out = client.sees(seconds(away, 0.3), turned(0))
    known = out[..., 3] > 0
    assert np.abs(out[known][:, :3] - 0.25).max() <= HALF_FLOAT
    assert known.mean() > 0.9, "what stayed is still known"


@pytest.mark.parametrize("moved_on", [False, True])
@pytest.mark.parametrize("what", ["ids", "velocity"])
def test_moving_bodies_are_never_remembered(gpu, client, what, moved_on):
    """The square is a body of its own, or deforms.

    Also where a pass before the warp has used up what tells it apart.
    """
    image = drawn(gpu, BEFORE_A_WALL, turned(0))
    moving = np.abs(read(image.colour)[..., 0] - 0.5) <= HALF_FLOAT
    assert moving.sum() > 100
    if what == "ids":
        texture = allocate(gpu.gl, SIZE, NUMBER)
        texture.write(moving.astype(np.uint16).tobytes(), alignment=1)
    else:
        texture = allocate(gpu.gl, SIZE, COLOUR)
        texture.write((moving[..., None] * np.array([0, 0, 0, 1.0])).astype(np.float16).tobytes(), alignment=1)
    rendered = image.having(**{what: BodyIds(texture) if what == "ids" else texture})
    inputs = PassInputs(image, turned(0), drawn=rendered) if moved_on else PassInputs(rendered, turned(0))
    client.fill.run(inputs, client.empty, client.into)
    out = client.sees(seconds(drawn(gpu, scene_of(WALL), turned(-60)), 1), turned(0))
    assert not (np.abs(out[..., 0] - 0.5) <= HALF_FLOAT).any()
    assert (out[..., 3] > 0).mean() > 0.8


def test_both_eyes_share_what_they_saw(gpu, client):
    wall = scene_of(WALL)
    client.sees(seconds(drawn(gpu, wall, turned(0)), 0), turned(0), eye=0)
    out = client.sees(seconds(drawn(gpu, wall, turned(-60, x=0.06)), 1), turned(0, x=0.06), eye=1)
    assert (out[..., 3] > 0).mean() > 0.9


def test_old_pictures_and_those_of_another_run_are_forgotten(gpu):
    wall = scene_of(WALL)
    for later, known in ((1.9, True), (2.1, False), (-1.0, False)):
        client = Client(gpu, "memory:age=2")
        client.sees(seconds(drawn(gpu, wall, turned(0)), 5), turned(0))
        out = client.sees(seconds(drawn(gpu, wall, turned(-60)), 5 + later), turned(0))
        assert ((out[..., 3] > 0).mean() > 0.9) == known, later
        client.close()


def test_learning_alone_teaches_what_a_shown_refresh_does(gpu):
    """Bit for bit, also where a frame is shown again after it was learned."""
    frames = [seconds(drawn(gpu, BEFORE_A_WALL, turned(25 * k)), k) for k in range(4)]
    seeing, learning = Client(gpu), Client(gpu)
    for rendered in frames:
        seeing.sees(rendered, rendered.view)
        learning.fill.learn(PassInputs(rendered, rendered.view))
    pictures = [each.sees(frames[-1], turned(20)) for each in (seeing, learning)]
    assert np.array_equal(*pictures) and (pictures[0][..., 3] > 0).mean() > 0.9
    for each in (seeing, learning):
        each.close()


def test_mb_bounds_how_many_are_kept_and_too_few_are_told(gpu):
    (choice,) = parse_fills("memory:mb=1")
    fill = choice.entry(gpu, (200, 100), (20, 10), choice.settings)
    assert len(fill._slots) == 3  # of 0.26 MB each
    fill.close()
    with pytest.raises(InputError, match=r"mb=1': one rendered picture of 400x300 takes 2 MB; give it more"):
        choice.entry(gpu, (400, 300), (20, 10), choice.settings)


# --- which pictures are kept and looked into ----------------------------------------------------


def keyframe(slot: int, degrees: float, x: float = 0, s: float = 0) -> Keyframe:
    return Keyframe(slot, turned(degrees, x), round(s * 1e9))


def test_a_view_is_new_if_no_near_one_covers_it():
    kept = [keyframe(0, 0)]
    assert not is_new(turned(2), kept)
    assert is_new(turned(30), kept)
    assert is_new(turned(0, x=0.4), kept)
    assert is_new(turned(180), [])
    assert covered(turned(0), kept).all()


def test_room_is_made_by_what_the_others_cover():
    kept = [keyframe(0, -40, s=1), keyframe(1, 0, s=2), keyframe(2, 20, s=3), keyframe(3, 45, s=4)]
    assert most_redundant(kept, turned(60)).slot in (1, 2)
    same = [keyframe(0, 0, s=1), keyframe(1, 0, s=2), keyframe(2, 90, s=3)]
    assert most_redundant(same, turned(-90)).slot == 0, "of equals the oldest"


def test_the_most_useful_pictures_look_where_the_rendered_view_does_not():
    kept = [keyframe(0, 60, s=1), keyframe(1, -30, s=2), keyframe(2, 180, s=3), keyframe(3, 0, s=4)]
    chosen = most_useful(kept, turned(30), turned(0), 1)
    assert [picture.slot for picture in chosen] == [0]
    chosen = most_useful(kept, turned(30), turned(0), 4)
    assert 2 not in [picture.slot for picture in chosen], "it looks the other way"
    assert [picture.drawn_ns for picture in chosen] == sorted((picture.drawn_ns for picture in chosen), reverse=True)
    beside = [keyframe(0, 60, x=0.4, s=1), keyframe(1, 60, x=0, s=2)]
    assert most_useful(beside, turned(30, 0.4), turned(0), 1)[0].slot == 0, "it is where the eye is"


def test_random_pictures_fill_holes_and_are_forgotten_as_before(gpu, tmp_path):
    pictures = []
    for seed, cell, halved in ((1, 1, False), (2, 2, True), (3, 4, False), (4, 2, True)):
        holed = Holed(gpu, seed, (67, 53), empty=0.6)
        world, holes, into = holed.world, HoleFiller(gpu, holed.size, cell), holed.picture(gpu)
        holes.start(holed.picture(gpu), into)
        beside = [EyeImage(world._beside(), *world._textures(gpu, *world._picture())) for _ in range(2)]
        for image in (world.rendered, *beside):
            seeds = seeds_for(gpu, world.size) if halved else None
            if halved:
                Keeper(gpu, world.size).seed(image.inverse_depth, seeds)
            holes.add(image, world.shown_view, seeds=seeds, newest=image is world.rendered)
        gpu.barrier()
        pictures.append((read(into.colour.texture), read(into.inverse_depth)[..., 0]))
        holes.close()
    for seed in (5, 6):
        world = World(gpu, seed, (66, 53))
        newest = EyeImage(world._beside(), *world._textures(gpu, *world._picture()))
        keeper, slot = Keeper(gpu, world.size), Slot(gpu, world.size)
        keeper.keep(world.rendered, slot)
        for turn in range(3):  # at each, one pixel of a block stands for all of it
            keeper.forget(slot, world.rendered_view, newest, turn)
        gpu.barrier()
        pictures.append((read(slot.colour), read(slot.inverse_depth)[..., 0]))
        assert 20 < (pictures[-1][1] < 0).sum() < world.inverse_depth.size
    assert_golden("effects/memory", sheet(*pictures), tmp_path)
