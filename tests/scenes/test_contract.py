"""Promises of every registered scene, and of the room besides."""

from __future__ import annotations

import attrs
import numpy as np
import pytest

from hmdwarp.client.effects import effects
from hmdwarp.errors import SceneError
from hmdwarp.scenes import Material, Mesh, Scene, Texture, load_scene, scenes

NAMES = scenes.names()


@pytest.fixture(scope="module", params=NAMES)
def scene(request):
    return load_scene(request.param)


@pytest.fixture(scope="module")
def room():
    return load_scene("room")


def test_a_scene_says_what_its_source_says(scene):
    source = scenes.get(scene.name)
    assert (source.summary, source.effects) == (scene.summary, effects.of(scene))
    assert scene.summary


def test_plain_still_scenes_call_for_no_effect(scene):
    moves = scene.lamps or any(mesh.body or mesh.deformation is not None for mesh in scene.meshes)
    assert scene.is_still == (not moves and not effects.of(scene))
    assert not attrs.evolve(scene, meshes=()).is_still  # nothing is known of what a camera sees


def test_meshes_are_drawable(scene):
    assert scene.triangle_count == sum(len(mesh.triangles) for mesh in scene.meshes) > 0
    for mesh in scene.meshes:
        assert np.isfinite(mesh.positions).all()
        # float32 keeps 7 digits of a unit vector
        assert np.abs(np.linalg.norm(mesh.normals, axis=1) - 1).max() < 1e-5
        assert mesh.triangles.max() < len(mesh.positions)
        assert (mesh.light >= 0).all()
        assert np.abs(mesh.uv).max() < 1000  # beyond, float32 uv would show texels swimming


def test_normals_and_winding_agree(scene):
    for mesh in scene.meshes:
        a, b, c = (mesh.positions[mesh.triangles[:, i]].astype(np.float64) for i in range(3))
        across = np.cross(b - a, c - a)
        area = np.linalg.norm(across, axis=1)
        mean = mesh.normals[mesh.triangles].mean(axis=1)
        agree = np.einsum("ij,ij->i", across, mean) > 0
        # A corner's normal is a mean over its neighbours: at thin rims and sharp bends it may point
        # away from one of its triangles.
        assert area[~agree].sum() <= 0.03 * area.sum(), mesh.name


def test_the_viewer_stands_where_a_head_may_go(scene):
    low, high = scene.walk_bounds_m
    assert (low < high).all()
    assert ((low <= scene.viewpoint.position_m) & (scene.viewpoint.position_m <= high)).all()
    assert np.allclose(scene.viewpoint.transform((0, 0, -1)) - scene.viewpoint.position_m, (0, 0, -1))


def test_building_twice_gives_the_same_bits(scene):
    again = scenes.get(scene.name).build.__wrapped__()  # past what conftest.py keeps
    assert again is not scene
    assert [mesh.name for mesh in again.meshes] == [mesh.name for mesh in scene.meshes]
    for first, second in zip(scene.meshes, again.meshes, strict=True):
        for field in ("positions", "normals", "uv", "light", "triangles"):
            assert np.array_equal(getattr(first, field), getattr(second, field))
    for first, second in zip(scene.textures, again.textures, strict=True):
        assert np.array_equal(first.image, second.image)


def mesh_with(**changes) -> Mesh:
    ones = np.ones((3, 3))
    fields = {"positions": ones, "normals": ones, "uv": np.ones((3, 2)), "light": ones, "triangles": [(0, 1, 2)]}
    return Mesh("bent", **(fields | changes))


MATERIALS = (
    {"tint": (1.0, 1.0)}, {"see_through": True, "tint": (1.2, 1.0, 1.0)}, {"tint": (0.5, 1.0, 1.0)},
    {"transmission": 0.5}, {"see_through": True, "transmission": 1.5}, {"see_through": True, "head_locked": True},
)  # fmt: skip


@pytest.mark.parametrize(
    ("make", "message"),
    [
        *((lambda wrong=wrong: Material(**wrong), "material") for wrong in MATERIALS),
        (lambda: mesh_with(positions=[(0, 0, 0), (0, np.nan, 0), (1, 1, 1)]), "positions of vertex 1"),
        (lambda: mesh_with(normals=np.full((3, 3), np.inf)), "normals of vertex 0"),
        (lambda: mesh_with(uv=np.ones((2, 2))), "3 positions but 2 uv"),
        (lambda: mesh_with(light=np.ones(3)), r"expected an \(n, 3\) array"),
        (lambda: mesh_with(triangles=[(0, 1, 3)]), "vertex 3, but there are only 3"),
        (lambda: Scene("bent", "", (mesh_with(texture=2),)), "uses texture 2, the scene has 0"),
        (lambda: Texture("bent", np.zeros((2, 2, 3))), "float64"),
    ],
)
def test_impossible_parts_of_a_scene_are_refused_by_name(make, message):
    with pytest.raises(SceneError, match=message):
        make()
