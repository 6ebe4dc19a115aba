"""What holds for every layer that the server draws beside the picture, and what it refuses."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from golden_pictures import assert_golden, sheet
from worlds import read

from hmdwarp.errors import InputError, MachineError, SceneError, UnknownNameError
from hmdwarp.frames import Mirrored, Needs
from hmdwarp.frames.layers import layers
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.scenes import Material, Quad, Scene, load_scene, scenes

SIZE = (40, 30)
VIEWS = [View(Pose((x, 1.6, 0.2)), Fov(-0.7, 0.8, -0.6, 0.75)) for x in (-0.03, 0.03)]
DRAWN = [layer.name for layer in layers if layer.drawn_by and layer.formats]


@pytest.mark.parametrize("name", DRAWN)
@pytest.mark.parametrize("scene", ["planes", "gallery"])
def test_a_layer_leaves_depth_as_it_is_and_its_textures_are_used_again(serve, scene, name):
    """And the picture, where the scene has nothing that goes into the layer alone."""
    server, needs = serve(scene), Needs(**{name: layers.get(name).something})
    alone = server.draw_frame(VIEWS, 7, SIZE)
    beside = server.draw_frame(VIEWS, 7, SIZE, needs=needs)
    assert [eye.view.pose for eye in beside.eyes] == [view.pose for view in VIEWS] and beside.drawn_ns == 7
    for one, other in zip(alone.eyes, beside.eyes, strict=True):
        assert name not in one and name in other
        assert one.inverse_depth.read() == other.inverse_depth.read()
        assert one.colour.read() == other.colour.read() or (scene, name) == ("gallery", "reflection")
    held = {texture for eye in beside.eyes for texture in eye.textures()}
    made, live = sum(pool.made for pool in server._pools.values()), sum(pool.live for pool in server._pools.values())
    server.recycle(beside)
    again = server.draw_frame(VIEWS, 8, SIZE, needs=needs)
    assert {texture for eye in again.eyes for texture in eye.textures()} == held
    assert sum(pool.made for pool in server._pools.values()) == made
    assert sum(pool.live for pool in server._pools.values()) == live
    server.recycle(again)
    server.recycle(alone)
    assert not any(pool.live for pool in server._pools.values())
    with pytest.raises(ValueError, match="not out"):
        server.recycle(again)


@pytest.mark.parametrize("name", scenes.names())
def test_a_scene_and_its_layers_look_as_before(gpu, serve, tmp_path, name):
    """Some way into its motions; what a pixel must be is known of simpler scenes, by rays."""
    server, needs = serve(name), Needs(peeled=1, transparent=True, overlay=True, reflection=~Mirrored(0))
    view, at_ns = View(server.scene.viewpoint, VIEWS[0].fov), 700_000_000
    whole, (eye,) = (
        server.draw(view, (96, 72), time_ns=at_ns),
        server.draw_frame([view], at_ns, (96, 72), needs=needs).eyes,
    )
    found = [read(texture) for texture in (whole.colour, whole.inverse_depth, *eye.textures())]
    pairs = [(each if each.shape[2] == 4 else each.repeat(4, axis=2), None) for each in found]
    share = 1 / 1000 if gpu.is_software else 1 / 20
    assert_golden(f"server/{name}", sheet(*pairs), tmp_path, share=share)


def test_a_plain_scene_has_nothing_to_tell_and_pays_nothing(gpu, serve):
    server, before = serve("planes"), None
    for _ in range(2):
        server.recycle(server.draw_frame(VIEWS, 0, SIZE))
        assert before in (None, len(gpu.shaders))
        before = len(gpu.shaders)
    assert not server._moving and "reflections" not in {name for _, name in server._parts}


class Bent:
    def __init__(self, positions) -> None:
        self._positions = np.array(positions)

    def positions(self, time_ns: int) -> np.ndarray:
        return self._positions

    velocities = positions


def bent(positions) -> Scene:
    mesh = Quad((0, 1.6, -2), (0.4, 0, 0), (0, 0.4, 0), -1, (0, 0, 1)).mesh("soft")
    return attrs.evolve(load_scene("planes"), meshes=[attrs.evolve(mesh, deformation=Bent(positions))])


def test_a_deforming_mesh_without_triangles_draws_nothing(serve):
    scene = bent(np.zeros((4, 3)))
    bare = attrs.evolve(scene.meshes[0], triangles=np.empty((0, 3), np.uint32))
    server = serve(attrs.evolve(scene, meshes=[bare]))
    assert not any(server.draw(VIEWS[0], SIZE).inverse_depth.read())


GIVES = "mesh 'soft': its deformation gives "
NARROW = View(Pose(), Fov.symmetric(0.02, 0.02))
REFUSED = {
    "no width": (lambda serve: serve("planes").draw(VIEWS[0], (0, 5)), InputError, "0x5"),
    "no height": (lambda serve: serve("planes").draw(VIEWS[0], (5, 0)), InputError, "5x0"),
    "too wide": (lambda serve: serve("planes").draw(VIEWS[0], (10**6, 5)), InputError, "1000000x5"),
    "a target of another size": (
        lambda serve: (server := serve("planes")).draw(VIEWS[0], (9, 8), server.pool((8, 8)).acquire()),
        InputError,
        "8x8",
    ),
    "mirrors": (lambda serve: serve("planes", mirrors="scren"), UnknownNameError, "kind of mirrors 'scren'"),
    "samples": (
        lambda serve: serve("planes", samples=4096),
        MachineError,
        r"--samples 4096: .* draws at most \d+ a pixel",
    ),
    "a cube beyond the GPU": (
        lambda serve: serve("planes").draw_frame([NARROW], 0, (640, 640), needs=Needs(cube=True)),
        InputError,
        r"a cube map as sharp as a picture of 640x640 would have \d+x\d+ pixels: .* use a smaller size",
    ),
    "a mesh that grows": (
        lambda serve: serve(bent(np.zeros((7, 3)))).draw(VIEWS[0], SIZE),
        SceneError,
        GIVES + r"positions of shape \(7, 3\), expected \(4, 3\)",
    ),
    "a mesh that is lost": (
        lambda serve: serve(bent(np.full((4, 3), np.nan))).draw(VIEWS[0], SIZE),
        SceneError,
        GIVES + ".*not finite",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_drawn_is_refused_by_name(serve, case):
    draw, error, message = REFUSED[case]
    with pytest.raises(error, match=message):
        draw(serve)


@pytest.mark.parametrize(
    "changes",
    [
        {"tint": (1.0, 1.0)},
        {"see_through": True, "tint": (1.2, 1.0, 1.0)},
        {"tint": (0.5, 1.0, 1.0)},
        {"transmission": 0.5},
        {"see_through": True, "transmission": 1.5},
        {"see_through": True, "head_locked": True},
    ],
)
def test_impossible_materials_are_refused(changes):
    with pytest.raises(SceneError):
        Material(**changes)
