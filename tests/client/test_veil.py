"""The veil and the overlay on the client. Against their float64 twins, behind what hides them, and
not at all where there is none."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from golden_pictures import assert_golden, sheet
from reference.picture import HALF_UNIT
from worlds import World, read

from hmdwarp.client import ShownPicture
from hmdwarp.client.effects import Tools
from hmdwarp.client.effects.compositing import NEARER, OverlayPass, TransparencyPass
from hmdwarp.frames import EyeImage, Needs, Surface, Transparent
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import COLOUR, SCALAR, Canvas, allocate
from hmdwarp.scenes import load_scene
from hmdwarp.sources.server import Server

SIZES = [((64, 48), (64, 48)), ((61, 43), (50, 37)), ((1, 1), (3, 2))]
UNKNOWN = -1.0
TOOLS = Tools(carry=None, pictures=0)  # nothing is carried or hidden


class Veiled:
    """A random world as the veil, random shares that pass it, and a random shown picture with holes
    to lay it over."""

    def __init__(self, gpu, seed: int, sizes: tuple, *, moved: bool = True) -> None:
        self.world = world = World(gpu, seed, *sizes, moved=moved)
        self.gpu, rng = gpu, np.random.default_rng(seed + 100)
        covered = world.colour[..., 3:]
        self.passing = (
            np.where(covered > 0, rng.uniform(0, 1, covered.shape[:2] + (3,)), 1).astype(np.float16).astype(float)
        )
        w, h = world.shown_size
        self.behind = (
            np.concatenate([rng.uniform(0, 2, (h, w, 3)), np.ones((h, w, 1))], axis=2).astype(np.float16).astype(float)
        )
        self.behind[rng.uniform(size=(h, w)) < 0.1] = 0

    def lay(self, shown_depth: np.ndarray | float = UNKNOWN) -> np.ndarray:
        world, gl = self.world, self.gpu.gl
        passing = allocate(gl, world.size, COLOUR)
        passing.write(np.dstack([self.passing, world.colour[..., 3]]).astype(np.float16).tobytes(), alignment=1)
        picture = ShownPicture(Canvas(gl, world.shown_size), allocate(gl, world.shown_size, SCALAR))
        picture.colour.texture.write(self.behind.astype(np.float16).tobytes(), alignment=1)
        depth = np.broadcast_to(np.float32(shown_depth), self.behind.shape[:2])
        picture.inverse_depth.write(np.ascontiguousarray(depth, np.float32).tobytes(), alignment=1)
        veil = Surface(world.rendered.colour, world.rendered.inverse_depth)
        rendered = world.rendered.having(transparent=Transparent(veil, passing))
        made = TransparencyPass(self.gpu, frozenset({"transparency"}), world.size, world.shown_size, TOOLS)
        found = []
        for _ in range(2):
            into = Canvas(gl, world.shown_size)
            made.run(attrs.evolve(world.inputs(None), rendered=rendered), picture, into)
            gl.memory_barrier()
            found.append(read(into.texture))
        assert np.array_equal(*found), "two runs differ"
        made.close()
        return found[0]


def test_the_veil_over_random_pictures_looks_as_before(gpu, tmp_path):
    """Its holes stay holes, and what is covered stays so."""
    pictures = []
    for number in range(2 * len(SIZES)):
        veiled = Veiled(gpu, number // len(SIZES), SIZES[number % len(SIZES)])
        found, holes = veiled.lay(), veiled.behind[..., 3] == 0
        assert (found[holes] == 0).all() and (found[~holes][:, 3] == 1).all() and np.isfinite(found).all()
        pictures.append((found, None))
    assert_golden("effects/veil", sheet(*pictures), tmp_path)


@pytest.mark.parametrize("seed", range(3))
def test_an_unmoved_head_gets_light_times_what_passes_plus_the_veil(gpu, seed):
    veiled = Veiled(gpu, seed, SIZES[0], moved=False)
    found, world, behind = veiled.lay(), veiled.world, veiled.behind
    shows = (world.inverse_depth >= 0) & (behind[..., 3] > 0)
    expected = np.where(shows[..., None], veiled.passing * behind[..., :3] + world.colour[..., :3], behind[..., :3])
    assert (np.abs(found[..., :3] - expected) <= HALF_UNIT * np.abs(expected) + 1e-6).all()  # one store in half floats


def test_a_thing_in_front_of_the_veil_hides_it(gpu):
    veiled = Veiled(gpu, 1, SIZES[0], moved=False)
    depth = veiled.world.inverse_depth
    assert np.array_equal(veiled.lay(1e9), veiled.behind)
    just_behind, just_before = (
        np.where(depth >= 0, np.maximum(depth, 0) * factor, 0) for factor in (1 / NEARER, NEARER * 1.001)
    )
    assert np.array_equal(veiled.lay(just_behind), veiled.lay())
    finite = depth > 0
    assert np.array_equal(veiled.lay(just_before)[finite], veiled.behind[finite])


@pytest.mark.parametrize("size", [(64, 48), (33, 17), (1, 1)])
def test_the_overlay_lies_over_the_picture_and_fills_holes_where_nothing_passes(gpu, size):
    rng, gl = np.random.default_rng(size[0]), gpu.gl
    shape = size[::-1]
    behind = np.concatenate([rng.uniform(0, 2, (*shape, 3)), np.ones((*shape, 1))], axis=2)
    behind[rng.uniform(size=shape) < 0.3] = 0
    alpha = rng.choice([0.0, 0.25, 0.5, 1.0], size=shape)
    over = np.concatenate([rng.uniform(0, 1, (*shape, 3)) * alpha[..., None], alpha[..., None]], axis=2)
    behind, over = (layer.astype(np.float16).astype(float) for layer in (behind, over))
    picture, into, overlay = Canvas(gl, size), Canvas(gl, size), allocate(gl, size, COLOUR)
    picture.texture.write(behind.astype(np.float16).tobytes(), alignment=1)
    overlay.write(over.astype(np.float16).tobytes(), alignment=1)
    view = View(Pose(), Fov(-0.5, 0.5, -0.5, 0.5))
    world = World(gpu, 0, (8, 8))
    inputs = attrs.evolve(world.inputs(None), rendered=EyeImage(view, overlay, overlay, {"overlay": overlay}))
    made = OverlayPass(gpu, frozenset({"overlay"}), (8, 8), size, TOOLS)
    made.run(inputs, ShownPicture(picture), into)
    gl.memory_barrier()
    found = read(into.texture)
    covered = (behind[..., 3] == 1) | (over[..., 3] == 1)
    expected = (over[..., :3] + (1 - over[..., 3:]) * behind[..., :3]) * covered[..., None]
    assert np.array_equal(found[..., 3], covered)
    assert (np.abs(found[..., :3] - expected) <= HALF_UNIT * expected + 1e-6).all()
    made.close()


def shown(gpu, scene: str, needs: Needs, run) -> tuple[np.ndarray, np.ndarray]:
    """The unmoved picture in layers, composited by `run`, and the whole one."""
    server, size = Server(gpu, load_scene(scene)), (120, 150)
    view = View(server.scene.viewpoint, Fov(-0.7, 0.7, -0.7, 0.7), Pose((-0.03, 0, 0)))
    whole = read(server.draw(view, size).colour)
    rendered = server.draw_frame([view], 0, size, needs=needs).eyes[0]
    canvas, into = Canvas(gpu.gl, size), Canvas(gpu.gl, size)
    canvas.texture.write(rendered.colour.read())
    inputs = attrs.evolve(World(gpu, 0, size).inputs(None), rendered=rendered, shown=view)
    run(size, inputs, ShownPicture(canvas, rendered.inverse_depth), into)
    gpu.gl.memory_barrier()
    out = read(into.texture)
    server.close()
    return out, whole


@pytest.mark.parametrize(
    ("scene", "needs", "made_by"),
    [("greenhouse", Needs(transparent=True), TransparencyPass), ("cockpit", Needs(overlay=True), OverlayPass)],
)
def test_a_real_scene_taken_apart_and_put_together_is_the_same(gpu, scene, needs, made_by):
    def run(size, inputs, picture, into):
        made = made_by(gpu, frozenset({"transparency", "overlay"}), size, size, TOOLS)
        made.run(inputs, picture, into)
        made.close()

    found, whole = shown(gpu, scene, needs, run)
    error = np.abs(found - whole).max(axis=-1)
    # Six sheets at most on a ray, each rounded once to a half float of a light of 1 or less, both
    # ways: 12 units. A pane that ends in its frame is within NEARER of it: there, along one row of
    # pixels or two, either may be in front.
    assert (error <= 12 * HALF_UNIT).mean() > 0.985
    assert np.median(error) <= HALF_UNIT
