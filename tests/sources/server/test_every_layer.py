"""What holds for every layer that the server draws beside the picture, what it refuses, and what
frames leave behind: as many targets as are used, and pictures as before."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from golden_pictures import assert_golden, sheet
from worlds import read

from hmdwarp.base import InputError, MachineError, SceneError, UnknownNameError
from hmdwarp.frames import Mirrored, Needs
from hmdwarp.frames.layers import layers
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import download
from hmdwarp.scenes import Quad, Scene, load_scene, scenes
from hmdwarp.sources.server import Server
from hmdwarp.sources.server.targets import IDLE_AFTER, MOST_IDLE, MOST_IDLE_BYTES

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


def burst(server: Server, number: int) -> None:
    """Draw so many frames before the first is taken back."""
    frames = []
    for each in range(number):
        frames.append(server.draw_frame(VIEWS[:1], each, SIZE))
        # llvmpipe keeps what it draws at the same time for as long as it likes.
        server.gpu.gl.finish()
    for frame in frames:
        server.recycle(frame)


def rest(server: Server, hand_outs: int = 2 * IDLE_AFTER) -> None:
    """Hand out one target at a time; what a hand-out needed stays for IDLE_AFTER more."""
    pool = server.pool(SIZE)
    for _ in range(hand_outs):
        pool.release(pool.acquire())


def test_targets_of_a_burst_are_freed_and_the_others_keep_their_pictures(serve):
    server = serve("planes")
    pool, held = server.pool(SIZE), server.draw_frame(VIEWS[:1], 0, SIZE)
    picture = download(held.eyes[0].colour)
    burst(server, 16)
    assert (pool.live, pool.made) == (1, 17)
    rest(server)
    assert (pool.live, pool.made) == (1, 2)
    np.testing.assert_array_equal(download(held.eyes[0].colour), picture)
    # GL gives names of freed textures to new ones, which need framebuffers of their own.
    frames = [server.draw_frame(VIEWS[:1], each, SIZE) for each in range(16)]
    for frame in frames:
        np.testing.assert_array_equal(download(frame.eyes[0].colour), picture)
        server.recycle(frame)
    server.recycle(held)


def test_of_what_many_sizes_needed_a_bounded_part_is_kept(serve):
    """As `serve` trims, after each frame that a client requests."""
    server = serve("planes")
    held = server.draw_frame(VIEWS[:1], 0, SIZE)
    picture = download(held.eyes[0].colour)
    server.recycle(held)
    sizes = [(8 + number, 9) for number in range(3 * MOST_IDLE)] + [(1024, 256 + number) for number in range(24)]
    for size in [*sizes, SIZE]:
        frame = server.draw_frame(VIEWS[:1], 0, size, needs=Needs(velocity=1, overlay=1))
        server.recycle(frame)
        server.trim()
        assert len(server._pools) <= MOST_IDLE + 8
        assert sum(pool.bytes for pool in server._pools.values()) <= MOST_IDLE_BYTES + 6 * 8 * size[0] * size[1]
        assert len(server._framebuffers._depth) <= MOST_IDLE + 1
    np.testing.assert_array_equal(download(frame.eyes[0].colour), picture)
