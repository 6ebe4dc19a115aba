"""Several pictures, or several layers of one: what one saw fills what another did not."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from reference.picture import RenderedPicture
from worlds import World, assert_equals_twin, read, shown_by

from hmdwarp.client import PassInputs, parse_warp
from hmdwarp.frames import EyeImage, Surface
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import COLOUR, SCALAR, Canvas, allocate
from hmdwarp.scenes import Background, Mesh, Scene
from hmdwarp.sources.server import Server, Target

SIZE = (120, 96)
FOV = Fov.from_tangents((-1, 1, -0.8, 0.8))
HALF_FLOAT = 2.0**-9  # flat colours: what is seen is right to the rounding of a half float


def square(depth_m: float, centre: tuple[float, float], half: float, level: float) -> Mesh:
    x, y = centre
    corners = [(x + i * half, y + j * half, -depth_m) for i, j in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    light = np.full((4, 3), level)
    return Mesh(
        f"square {level}", corners, np.tile((0, 0, 1.0), (4, 1)), np.zeros((4, 2)), light, [(0, 1, 2), (0, 2, 3)], -1,
        False,
    )  # fmt: skip


def scene_of(*squares: Mesh) -> Scene:
    return Scene("squares", "", squares, background=Background.uniform((1, 1, 1)))


WALL = square(3, (0, 0), 20, 0.25)
BEFORE_A_WALL = scene_of(square(1, (0, 0), 0.25, 0.5), WALL)


def drawn(gpu, scene: Scene, view: View, size=SIZE, target=None) -> EyeImage:
    """A picture in textures of its own, whose server is gone."""
    server = Server(gpu, scene)
    image = server.draw(view, size, Target(allocate(gpu.gl, size, COLOUR), allocate(gpu.gl, size, SCALAR)))
    gpu.gl.finish()
    server.close()
    return image


def put_together(gpu, rendered: EyeImage, others: tuple[EyeImage, ...], shown: View) -> np.ndarray:
    return shown_by(gpu, "multi", PassInputs(rendered, shown, others=others), SIZE)[0]


def at(x: float, y: float = 0, z: float = 0) -> View:
    return View(Pose((x, y, z)), FOV)


def inner(picture: np.ndarray, margin: int = 14) -> np.ndarray:
    return picture[margin:-margin, margin:-margin]


def test_the_other_eye_fills_the_shadow_of_an_edge(gpu):
    """The newest stands left of the square and hides the wall to its right. The other eye, right of
    it, saw that."""
    newest, other = (drawn(gpu, BEFORE_A_WALL, at(x)) for x in (-0.1, 0.1))
    truth = inner(read(drawn(gpu, BEFORE_A_WALL, at(0)).colour))
    alone, both = (inner(put_together(gpu, newest, others, at(0))) for others in ((), (other,)))
    assert (alone[..., 3] == 0).mean() > 0.01
    assert (both[..., 3] == 0).mean() < 0.1 * (alone[..., 3] == 0).mean()
    assert (np.abs(both - truth).max(axis=-1) > HALF_FLOAT).mean() < 0.03, (
        "all but the square's outline, which is half a pixel off"
    )


def test_a_thing_that_left_is_not_painted_over_the_newest_frame(gpu):
    """A past frame holds a square that the newest, which looks right through its place, has not."""
    newest, past = drawn(gpu, scene_of(WALL), at(0.02)), drawn(gpu, BEFORE_A_WALL, at(0))
    out = put_together(gpu, newest, (past,), at(0.05))
    assert np.abs(inner(out)[..., :3] - 0.25).max() <= HALF_FLOAT


def test_without_others_it_is_the_newest_frame_alone_and_nothing_is_left_from_before(gpu):
    """The first refreshes have no past frames; and none may live on in the buffers."""
    newest, other = (drawn(gpu, BEFORE_A_WALL, at(x)) for x in (-0.1, 0.1))
    choice = parse_warp("multi")
    warp, canvas = choice.entry(gpu, SIZE, SIZE, choice.settings), Canvas(gpu.gl, SIZE)
    pictures = []
    for others in ((), (other,), (), (other, other, other), ()):
        warp.run(PassInputs(newest, at(0), others=others), canvas)
        gpu.gl.memory_barrier()
        pictures.append(read(canvas.texture))
    assert np.array_equal(pictures[0], pictures[2])
    assert np.array_equal(pictures[0], pictures[4])
    assert (pictures[1][..., 3] >= pictures[0][..., 3]).all()


@pytest.mark.parametrize("spec", ["multi", "multi:frames=0", "multi:frames=3", "multi:views=2,frames=1,eye=own"])
def test_any_number_of_pictures_equals_the_twin(gpu, spec):
    world = World(gpu, 30, (57, 43), (61, 40))
    needs = parse_warp(spec).entry.needs(parse_warp(spec).settings)
    # Views that the server chose come among the others.
    count = needs.others.count + needs.get("views", 0)
    world.others = tuple(RenderedPicture(*world._picture(), world._beside()) for _ in range(count))
    if not world.others:
        world.bring = lambda gpu, entry: None
    got, wanted = world.warp(gpu, spec), world.reference(spec)
    assert_equals_twin(got, wanted)


# --- layered: real content behind edges, no cracks, no guesses ------------------------------------


# A small square before a large wall before the sky.
SCENE = Scene(
    "walls", "", (square(1, (0, 0), 0.25, 0.5), square(3, (0, 0), 2, 0.25)), background=Background.uniform((1, 1, 1))
)


def shown_and_truth(gpu, step, size=SIZE) -> tuple[np.ndarray, np.ndarray]:
    server, choice, shown = Server(gpu, SCENE), parse_warp("layered"), View(Pose(step), FOV)
    rendered = server.draw_frame([View(Pose(), FOV)], 0, size, needs=choice.entry.needs(choice.settings)).eyes[0]
    out = shown_by(gpu, "layered", PassInputs(rendered, shown), size)[0]
    truth = read(server.draw(shown, size).colour)
    server.close()
    return out, truth


def near_an_edge(truth: np.ndarray, pixels: int = 1) -> np.ndarray:
    """Pixels next to another colour. An edge may be half a rendered pixel and half a shown one
    off."""
    marked = np.zeros(truth.shape[:2], bool)
    for axis in (0, 1):
        for k in range(1, pixels + 1):
            step = (np.abs(truth - np.roll(truth, k, axis)) > 1e-3).any(axis=-1)
            marked |= step | np.roll(step, -k, axis)
    return marked


@pytest.mark.parametrize("step", [(0.1, 0, 0), (-0.07, 0.05, 0), (0.02, -0.08, -0.1), (0, 0, 0.2)], ids=str)
def test_behind_an_edge_is_what_really_is_there(gpu, step):
    out, truth = (inner(picture) for picture in shown_and_truth(gpu, step))
    away = ~near_an_edge(truth)
    assert (out[..., 3] == 1).all()
    assert np.abs(out - truth)[away].max() <= 2.0**-9, (
        "flat colours: what is seen is right to the rounding of a half float"
    )


@pytest.mark.parametrize("layers", [2, 3, 4])
@pytest.mark.parametrize("seed", [20, 21])
def test_any_number_of_layers_equals_the_twin(gpu, layers, seed):
    world = World(gpu, seed, (57, 43), (61, 40))
    world.bring(gpu, parse_warp("layered").entry)
    if layers == 4:
        behind = attrs.evolve(world.layers[1], inverse_depth=world.layers[1].inverse_depth * 0.7)
        behind.inverse_depth[behind.inverse_depth < 0] = -1
        world.layers = (*world.layers, behind)
    spec = f"layered:layers={layers}"
    got, wanted = world.warp(gpu, spec) if layers < 4 else _warped_with(gpu, world, spec), world.reference(spec)
    assert_equals_twin(got, wanted)


def _warped_with(gpu, world: World, spec: str) -> np.ndarray:
    peeled = tuple(Surface(*world._textures(gpu, layer.colour, layer.inverse_depth)) for layer in world.layers)
    inputs = PassInputs(world.rendered.having(peeled=peeled), world.shown_view)
    return shown_by(gpu, spec, inputs, world.shown_size)[0]
