"""The layered warp on walls whose every view is known.

Real content behind edges, no cracks, no guesses beyond the rendered picture.
"""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from worlds import World, read

from client.test_multi import square
from hmdwarp.client import PassInputs, parse_warp
from hmdwarp.errors import PlanError
from hmdwarp.frames import Needs, Surface
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import SCALAR, Canvas, allocate
from hmdwarp.scenes import Background, Scene, load_scene
from hmdwarp.sources.server import Server

SIZE = (120, 96)
FOV = Fov.from_tangents((-1, 1, -0.8, 0.8))


# A small square before a large wall before the sky.
SCENE = Scene(
    "walls", "", (square(1, (0, 0), 0.25, 0.5), square(3, (0, 0), 2, 0.25)), background=Background.uniform((1, 1, 1))
)


def shown_and_truth(
    gpu, scene: Scene, step, spec: str = "layered", size=SIZE, guard: float = 1.0
) -> tuple[np.ndarray, np.ndarray]:
    server, choice = Server(gpu, scene), parse_warp(spec)
    rendered = server.draw_frame([View(Pose(), FOV)], 0, size, guard, choice.entry.needs(choice.settings)).eyes[0]
    shown = View(Pose(step), FOV)
    warp, canvas = choice.entry(gpu, rendered.size, size, choice.settings), Canvas(gpu.gl, size)
    warp.run(PassInputs(rendered, shown), canvas)
    gpu.gl.memory_barrier()
    out, truth = read(canvas.texture), read(server.draw(shown, size).colour)
    warp.close()
    canvas.release()
    server.close()
    return out, truth


def inner(out: np.ndarray, margin: int = 12) -> np.ndarray:
    """Without the rim that the rendered picture may not hold."""
    return out[margin:-margin, margin:-margin]


def near_an_edge(truth: np.ndarray, pixels: int = 1) -> np.ndarray:
    """Pixels next to another colour.

    An edge may be half a rendered pixel and half a shown one off.
    """
    marked = np.zeros(truth.shape[:2], bool)
    for axis in (0, 1):
        for k in range(1, pixels + 1):
            step = (np.abs(truth - np.roll(truth, k, axis)) > 1e-3).any(axis=-1)
            marked |= step | np.roll(step, -k, axis)
    return marked


@pytest.mark.parametrize("step", [(0.1, 0, 0), (-0.07, 0.05, 0), (0.02, -0.08, -0.1), (0, 0, 0.2)], ids=str)
def test_behind_an_edge_is_what_really_is_there(gpu, step):
    out, truth = (inner(picture) for picture in shown_and_truth(gpu, SCENE, step))
    away = ~near_an_edge(truth)
    assert (out[..., 3] == 1).all()
    assert np.abs(out - truth)[away].max() <= 2.0**-9, (
        "flat colours: what is seen is right to the rounding of a half float"
    )


@pytest.mark.parametrize("step", [(0, 0, -0.45), (0.05, 0.02, -0.5), (0, 0, -0.6)], ids=str)
def test_a_surface_twice_as_near_has_no_cracks(gpu, step):
    out, truth = (inner(picture) for picture in shown_and_truth(gpu, SCENE, step))
    away = ~near_an_edge(truth, 2)
    assert (out[..., 3] == 1).all()
    assert np.abs(out - truth)[away].max() <= 2.0**-9


def test_two_layers_do_not_know_the_third(gpu):
    """Before the small square stands a smaller one.

    Behind both of them the wall is only the third layer.
    """
    scene = attrs.evolve(SCENE, meshes=(square(0.9, (0, 0), 0.2, 0.75), *SCENE.meshes))
    covered = {}
    for spec in ("layered:layers=2", "layered:layers=3"):
        out, truth = (inner(picture) for picture in shown_and_truth(gpu, scene, (0.3, 0, 0), spec))
        covered[spec] = out[..., 3].mean()
        right = np.abs(out - truth).max(axis=-1) <= 2.0**-9
        assert right[out[..., 3] > 0].mean() > 0.97
    assert covered["layered:layers=3"] > covered["layered:layers=2"]
    assert covered["layered:layers=3"] > 0.999


def test_beyond_the_rendered_picture_hidden_things_do_not_come_forward(gpu):
    """A wall that fills the rendered view.

    Turned to the side, the sky behind it moves less and must not show beside it.
    """
    scene = Scene("wall", "", (square(1, (0, 0), 30, 0.25),), background=Background.uniform((1, 1, 1)))
    out, _ = shown_and_truth(gpu, scene, (0.3, 0, 0))
    assert (out[:, : SIZE[0] * 8 // 10, 3] == 1).all()
    assert (out[:, -SIZE[0] // 10 :] == 0).all()
    assert (out[..., :3] <= 0.26).all(), "no sky anywhere"


def test_in_the_room_it_is_better_than_the_visible_layer_alone(gpu):
    scene, size = load_scene("room"), (160, 128)
    server, choice = Server(gpu, scene), parse_warp("layered")
    eye = scene.viewpoint
    views = [View(Pose(eye.position_m + step, eye.orientation_xyzw), FOV) for step in ((0, 0, 0), (0.2, 0.05, 0.05))]
    rendered = server.draw_frame(views[:1], 0, size, 1.4, Needs(peeled=2)).eyes[0]
    nothing = (attrs.evolve(surface, inverse_depth=_nothing(gpu, rendered.size)) for surface in rendered["peeled"])
    alone = rendered.having(peeled=tuple(nothing))
    truth = read(server.draw(views[1], size).colour)
    warp, canvas = choice.entry(gpu, rendered.size, size, choice.settings), Canvas(gpu.gl, size)
    wrong, holes = [], []
    for inputs in (rendered, alone):
        warp.run(PassInputs(inputs, views[1]), canvas)
        gpu.gl.memory_barrier()
        out = read(canvas.texture)
        wrong.append(np.minimum((out - truth)[..., :3] ** 2, 1).mean())
        holes.append((out[..., 3] == 0).mean())
    server.close()
    assert holes[0] < 0.6 * holes[1], holes
    assert wrong[0] < wrong[1]


def _nothing(gpu, size):
    texture = allocate(gpu.gl, size, SCALAR)
    texture.write(np.full(size[::-1], -1, np.float32).tobytes(), alignment=1)
    return texture


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
    decided = ~wanted.undecided
    assert decided.mean() > 0.9
    assert np.array_equal(got[..., 3][decided], wanted.colour[..., 3][decided])
    assert (np.abs(got[..., :3] - wanted.colour[..., :3]).max(axis=-1) <= wanted.tolerance)[decided].all()


def _warped_with(gpu, world: World, spec: str) -> np.ndarray:
    choice = parse_warp(spec)
    peeled = tuple(Surface(*world._textures(gpu, layer.colour, layer.inverse_depth)) for layer in world.layers)
    rendered = world.rendered.having(peeled=peeled)
    warp, canvas = choice.entry(gpu, world.size, world.shown_size, choice.settings), Canvas(gpu.gl, world.shown_size)
    warp.run(PassInputs(rendered, world.shown_view), canvas)
    gpu.gl.memory_barrier()
    return read(canvas.texture)


def test_a_hole_without_depth_is_filled_by_no_neighbour(gpu):
    world = World(gpu, 3, (64, 48))
    world.inverse_depth[20:30, 20:30], world.colour[20:30, 20:30] = -1, 0
    world.shown_view = View(world.rendered_view.pose, world.rendered_view.fov)
    world.upload(gpu)
    out = world.warp(gpu, "layered")
    assert (out[20:30, 20:30] == 0).all()
    assert np.array_equal(out, world.colour)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, -1e-30, 3e38])
def test_no_depth_of_any_kind_neither_spreads_nor_shows(gpu, bad):
    """In the visible layer and behind it."""
    world, pictures = World(gpu, 4, (64, 48)), []
    world.bring(gpu, parse_warp("layered").entry)
    for no_depth in (-1, bad):
        for depth in (world.inverse_depth, *(layer.inverse_depth for layer in world.layers)):
            depth[::5, ::3] = no_depth
        world.upload(gpu)
        pictures.append(world.warp(gpu, "layered"))
    assert np.isfinite(pictures[1]).all()
    assert np.array_equal(*pictures)


def test_a_frame_with_fewer_layers_is_refused(gpu):
    world = World(gpu, 5, (16, 12))
    world.bring(gpu, parse_warp("layered").entry)
    choice = parse_warp("layered:layers=4")
    warp, canvas = choice.entry(gpu, world.size, world.shown_size, choice.settings), Canvas(gpu.gl, world.shown_size)
    with pytest.raises(PlanError, match="needs 3 layers behind the visible one, this frame has 2"):
        warp.run(PassInputs(world.rendered, world.shown_view), canvas)


def test_it_needs_these_layers_of_a_frame():
    choices = [parse_warp(f"layered:layers={n}") for n in (2, 3, 4)]
    assert [choice.entry.needs(choice.settings)["peeled"] for choice in choices] == [1, 2, 3]
