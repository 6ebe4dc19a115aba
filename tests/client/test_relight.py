"""Fills that draw: the model fills holes with what the scene is. Relight gives it the light of the
picture."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from worlds import read

from hmdwarp.client import ClientScene, ReducedModel
from hmdwarp.geometry import Pose, View
from hmdwarp.scenes import Body, Quad, Scene, load_scene
from hmdwarp.sources.server import Server

from .modelled import SIZE, VIEW, Shown, picture_of

STORED = 2.0**-10  # what is stored as a half float is truncated: 2^-10 of it


@pytest.mark.parametrize("scene", ["planes", "spheres"])
def test_the_whole_model_fills_with_the_truth(gpu, scene):
    shown = Shown(gpu, scene)
    colour, depth = shown.fill("model:share=1")
    assert np.array_equal(colour, shown.truth)
    assert np.array_equal(depth, shown.depth)


def by_server(gpu, scene: Scene, shown: Shown) -> np.ndarray:
    """(h, w, 4) what a server of that scene draws, in the holes."""
    drawn = read(Server(gpu, scene).draw(VIEW, shown.size).colour)
    return np.where(shown.holes[..., None], drawn, shown.colour)


def test_with_light_off_the_model_is_the_bare_albedo(gpu):
    """As a server draws a scene in which nothing but the albedo is left, put together by hand."""
    scene, shown = load_scene("spheres"), Shown(gpu, "spheres")
    assert all(mesh.albedo is not None for mesh in scene.meshes)
    bare = attrs.evolve(scene, meshes=[attrs.evolve(mesh, light=mesh.albedo) for mesh in scene.meshes])
    got, depth = shown.fill("model:share=1,light=off")
    assert np.array_equal(got, by_server(gpu, bare, shown))
    assert not np.array_equal(got, shown.fill("model:share=1")[0])
    assert np.array_equal(depth, shown.depth)


@attrs.frozen
class Sliding:
    def state(self, time_ns):
        from hmdwarp.geometry import RigidState

        return RigidState(Pose((time_ns * 1e-9, 0, 0)))


def test_bodies_are_drawn_where_they_are_when_shown(gpu):
    scene = load_scene("planes")
    moving = attrs.evolve(
        scene, meshes=[attrs.evolve(mesh, body=1) for mesh in scene.meshes], bodies=(Body("all", Sliding()),)
    )
    geometry, into = ClientScene(Server(gpu, moving)), picture_of(gpu, SIZE)
    geometry.store(ReducedModel, (1.0, 1.0)).drawn(lit=True).draw(VIEW, into, 250_000_000)
    still = Server(gpu, scene)
    seen = still.draw(View(Pose(VIEW.pose.position_m - (0.25, 0, 0)), VIEW.fov), SIZE)
    # The same triangles by another product of matrices: a few pixels on edges may differ.
    assert (read(into.colour.texture) == read(seen.colour)).all(axis=-1).mean() > 0.97


def test_without_anything_like_it_in_sight_the_models_own_light_is_left(gpu):
    shown = Shown(gpu, "spheres")
    shown.shown_depth = np.full_like(shown.shown_depth, -1)
    got, model = shown.fill("relight")[0], shown.fill("model")[0]
    assert np.abs(got - model).max() <= 2 * STORED * model.max()
    assert got[shown.holes, :3].max(axis=-1).min() > 0


def test_surfaces_that_face_away_give_no_light(gpu):
    """One side of a steep ridge that points at the eye is a hole, the other in coloured light."""
    sides = [
        Quad((VIEW.pose.position_m[0] + 0.18 * side, 1.6, -1.5), (0.18, 0, -0.5 * side), (0, 1, 0), -1, (0.5,) * 3)
        for side in (-1, 1)
    ]
    meshes = [attrs.evolve(side.mesh("side"), albedo=np.full((4, 3), 0.8)) for side in sides]
    shown = Shown(gpu, Scene("ridge", "", meshes), (3, 1, 0.2), holes=np.mgrid[: SIZE[1], : SIZE[0]][1] < 67)
    got, model = shown.fill("relight")[0], shown.fill("model:share=1")[0]
    assert ((shown.depth > 0) & shown.holes).sum() > 1000
    assert np.abs(got - model).max() <= 2 * STORED * model.max()
