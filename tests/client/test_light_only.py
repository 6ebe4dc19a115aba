"""Light-only frames: light and albedo apart and together again. Known lights, the product's float64
twin, exactness, and what is sent."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from client_scene import ClientScene
from replays import refreshed, small
from worlds import read

from hmdwarp.base import PlanError
from hmdwarp.client import PassInputs, ShownPicture, build_plan
from hmdwarp.client.effects import Tools, effects
from hmdwarp.frames import Needs
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import Canvas, download
from hmdwarp.run import set_up_replay
from hmdwarp.scenes import Emission, Scene, Texture, load_scene, only_light, unlit
from hmdwarp.sources.server import Server

NAME, SIZE, HALF = "light_only", (61, 43), 2.0**-10
VIEW = View(Pose((0.1, 1.5, 0.2), (0.1, 0.2, 0, 1)), Fov.from_tangents([-0.8, 0.8, -0.6, 0.6]))


def baked(light, albedo):
    """The scene `planes` with one light and albedo in every vertex of its surfaces."""
    scene = load_scene("planes")
    meshes = [
        attrs.evolve(
            mesh,
            light=np.broadcast_to(np.float32(light), mesh.light.shape),
            albedo=None if albedo is None else np.broadcast_to(np.float32(albedo), mesh.light.shape),
        )
        for mesh in scene.meshes
    ]
    return attrs.evolve(scene, meshes=meshes)


@pytest.mark.parametrize(
    ("light", "albedo"),
    [
        ((0.3, 0.2, 0.1), (0.5, 0.5, 0.5)),
        ((0, 0, 0), (0.5, 0.2, 0.9)),  # no light
        ((0, 0, 0), (0, 0, 0)),  # black
        ((4, 2, 0.5), (0, 0, 0)),  # glows, with a black albedo
        ((0.5, 0, 0), None),  # only the baked colour is known, and two channels have no hue
        ((0, 0, 0), None),
    ],
)
def test_light_times_albedo_is_what_was_baked(light, albedo):
    scene = baked(light, albedo)
    for falling, bare, mesh in zip(only_light(scene).meshes, unlit(scene).meshes, scene.meshes, strict=True):
        assert np.isfinite(falling.light).all() and (falling.light >= 0).all()
        # A float32 quotient and product of it: half a unit each.
        assert np.abs(falling.light * bare.light - mesh.light).max() <= 2 * 2.0**-23 * max(light)
        # As a half float it must not overflow.
        assert falling.light.max() < 65504


def shining(scene: Scene) -> Scene:
    """The scene with a chessboard on each texture that is up to 3 times white and black between."""
    board = np.kron(np.indices((4, 4)).sum(axis=0) % 2, np.ones((2, 2)))[..., None] * np.array([255, 128, 0])
    emission = Emission(board.astype(np.uint8), (3.0, 2.0, 1.0))
    textures = [Texture(one.name, one.image, one.srgb, one.repeat, emission) for one in scene.textures]
    return attrs.evolve(scene, textures=textures)


def test_what_textures_emit_is_not_scaled_by_the_light(gpu):
    """At no latency light, albedo and emission make the picture, which light alone would not."""
    scene = shining(load_scene("planes"))
    client, into = ClientScene(gpu, scene), Canvas(gpu.gl, SIZE)
    frame = client.server.draw_frame([VIEW], 0, SIZE, needs=Needs(light=True))
    one = effects.get(NAME).made_by(gpu, frozenset([NAME]), SIZE, SIZE, Tools(None, 1, geometry=client))
    late = Canvas(gpu.gl, SIZE)
    late.texture.write(download(frame.eyes[0].colour)[::-1].tobytes(), alignment=1)
    one.run(PassInputs(frame.eyes[0], VIEW), ShownPicture(late, None), into)
    gpu.gl.memory_barrier()
    got, truth = read(into.texture)[..., :3], read(client.server.draw(VIEW, SIZE).colour)[..., :3]
    assert truth.max() > 2.9
    # Light, albedo, emission and the result are half floats.
    assert np.abs(got - truth).max() <= 4 * HALF * truth.max()
    one.close()


@pytest.mark.parametrize("scene", ["planes", "room", "lantern", "doorway"])
def test_light_and_albedo_of_one_pose_are_the_picture(gpu, scene):
    """At no latency nothing is lost. Light, albedo and product are half floats; light that varies
    over a triangle beside an albedo that does too is not, but no scene here has such a triangle."""
    server = Server(gpu, load_scene(scene))
    view = View(server.scene.viewpoint, VIEW.fov)
    truth, bare = server.draw(view, SIZE), Server(gpu, unlit(load_scene(scene)))
    frame = server.draw_frame([view], 0, SIZE, needs=Needs(light=True))
    (eye,) = frame.eyes
    product = read(eye.colour)[..., :3] * read(bare.draw(view, SIZE).colour)[..., :3]
    wanted = read(truth.colour)[..., :3]
    assert np.abs(product - wanted).max() <= 3 * HALF * wanted.max()
    assert np.array_equal(read(eye.inverse_depth), read(truth.inverse_depth)), "the depth is the picture's own"
    # A tenth of white, and of the brightest where all is darker.
    apart = np.abs(read(eye.colour)[..., :3].astype(float) - wanted).max()
    assert apart > 0.1 * min(1.0, wanted.max()), "the picture sent is not the colour"
    server.recycle(frame)
    for closed in (server, bare):
        closed.close()


def shown_by(**options):
    """The third refresh's left eye and what a frame weighed, without mixed pixels."""
    asked = {"fill": "pyramid", "warp": "backward", "scene": "room", "samples": 1}
    with set_up_replay(small(**{**asked, **options})) as setup:
        refresh = refreshed(setup)
        truth = read(setup.server.draw(refresh.inputs[0].shown, setup.sizes.shown).colour)[..., :3]
        got = read(refresh.eyes[0].panel.texture)[..., :3]
        return np.abs(got - truth).mean(), setup.channel.transit.size_bytes


def test_it_is_sent_instead_of_the_colour_and_keeps_textures_sharp():
    late = {"trace": "walk", "latency_ms": 200.0}
    (error, sent), (plain_error, plain_sent) = shown_by(effects=NAME, **late), shown_by(**late)
    assert sent == plain_sent
    assert error < 0.75 * plain_error


@pytest.mark.parametrize(
    ("beside", "fill", "geometry", "why"),
    [
        ((), "none", False, "geometry on the client"),
        # They would be multiplied with the albedo once more.
        *(((), fill, True, "draws the scene in its colours") for fill in ("model", "memory+relight", "composite")),
        # They divide the late picture by the albedo, and here it is light.
        (("soft_bodies",), "none", True, "leave one of them out"),
    ],
)
def test_what_cannot_be_beside_it_is_refused(beside, fill, geometry, why):
    names = (NAME, *beside)
    with pytest.raises(PlanError, match=why):
        build_plan(names, "backward", fill, "none", client_geometry=geometry, named=names, forced=names)
