"""The layered warp on walls whose every view is known. Real content behind edges, no cracks, no
guesses beyond the rendered picture."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from worlds import World, assert_equals_twin, read, shown_by

from client.test_multi import square
from hmdwarp.client import PassInputs, parse_warp
from hmdwarp.errors import PlanError
from hmdwarp.frames import Surface
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import Canvas
from hmdwarp.scenes import Background, Scene
from hmdwarp.sources.server import Server

SIZE = (120, 96)
FOV = Fov.from_tangents((-1, 1, -0.8, 0.8))


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


def inner(out: np.ndarray, margin: int = 12) -> np.ndarray:
    """Without the rim that the rendered picture may not hold."""
    return out[margin:-margin, margin:-margin]


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


def test_a_frame_with_fewer_layers_is_refused(gpu):
    world = World(gpu, 5, (16, 12))
    world.bring(gpu, parse_warp("layered").entry)
    choice = parse_warp("layered:layers=4")
    warp, canvas = choice.entry(gpu, world.size, world.shown_size, choice.settings), Canvas(gpu.gl, world.shown_size)
    with pytest.raises(PlanError, match="needs 3 layers behind the visible one, this frame has 2"):
        warp.run(PassInputs(world.rendered, world.shown_view), canvas)
