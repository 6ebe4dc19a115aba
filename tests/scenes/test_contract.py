"""Promises of every registered scene, the parts that none may have, mirrors, and what is slow."""

from __future__ import annotations

import attrs
import numpy as np
import pytest

from hmdwarp.base import SceneError
from hmdwarp.client.effects import effects
from hmdwarp.geometry import Pose, RigidState
from hmdwarp.scenes import (
    Ball,
    Body,
    Material,
    Mesh,
    Quad,
    Scene,
    Spinning,
    Still,
    Texture,
    Waving,
    load_scene,
    scenes,
    slow_in,
)

NAMES = scenes.names()


@pytest.fixture(scope="module", params=NAMES)
def scene(request):
    return load_scene(request.param)


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


GREY = Texture("grey", np.full((2, 2, 3), 90, np.uint8))


def mirror(centre=(0, 0, -2), right=(1, 0, 0), up=(0, 0.5, 0), **material) -> Mesh:
    return attrs.evolve(Quad(centre, right, up).mesh("glass"), material=Material(**({"reflectivity": 0.5} | material)))


def scene_of(*meshes: Mesh, origin=(0.0, 0.0, 0.0), bodies=()) -> Scene:
    return Scene("mirrors", "", meshes, (GREY,), origin_m=origin, bodies=bodies)


def test_a_plane_mirror_is_its_rectangle_in_the_world():
    (found,) = scene_of(mirror(right=(0.6, 0, 0.8)), origin=(10.0, 20.0, 30.0)).mirrors
    assert np.allclose(found.shape.centre_m, (10, 20, 28))
    assert np.allclose(found.shape.right_m, (0.6, 0, 0.8))
    assert np.allclose(found.shape.up_m, (0, 0.5, 0))
    assert not found.shape.is_curved


def test_coplanar_equal_mirrors_are_one():
    left, right = mirror((-1, 0, -2)), mirror((3, 0, -2))
    (found,) = scene_of(left, right).mirrors
    assert len(found.meshes) == 2
    assert np.allclose(found.shape.centre_m, (1, 0, -2))
    assert np.allclose(found.shape.right_m, (3, 0, 0))
    assert len(scene_of(left, mirror((3, 0, -2.1))).mirrors) == 2
    assert len(scene_of(left, mirror((3, 0, -2), reflectivity=0.7)).mirrors) == 2


def test_the_right_of_a_mirror_is_where_its_u_grows():
    turned = attrs.evolve(mirror(), uv=mirror().uv[[1, 2, 3, 0]])
    (found,) = scene_of(turned).mirrors
    assert np.allclose(found.shape.right_m, (0, -0.5, 0))
    assert np.allclose(found.shape.normal, (0, 0, 1))


def test_a_curved_mirror_is_the_ball_around_it():
    ball = attrs.evolve(Ball((1, 2, 3), 0.4).mesh("ball"), material=Material(reflectivity=0.8, curved=True))
    (found,) = scene_of(ball).mirrors
    assert np.allclose(found.shape.centre_m, (1, 2, 3), atol=1e-6)
    assert found.shape.radius_m == pytest.approx(0.4, rel=1e-6)


TURNED = [(0, 0, 1), (0, 0, 1), (0, 1, 0), (0, 0, 1)]
BENT = np.array([(0, 0, 0), (0, 0, 0), (0, 0, 0.1), (0, 0, 0)])
BALL = attrs.evolve(Ball((0, 0, 0), 1.0).mesh("b"), material=Material(reflectivity=0.5))


@pytest.mark.parametrize(
    ("meshes", "message"),
    [
        ([attrs.evolve(mirror(), normals=np.zeros((4, 3)))], "'glass': a mirror without a normal: .* not of length 1"),
        ([attrs.evolve(mirror(), normals=TURNED)], "without a normal: its normals differ by up to .* deg"),
        (
            [attrs.evolve(mirror(), positions=mirror().positions + BENT)],
            "without a normal: its vertices leave a plane by 100 mm",
        ),
        ([attrs.evolve(mirror(), normals=-mirror().normals)], "without a normal: some triangles face away"),
        ([BALL], r"differ by up to .*\(curved=True\)"),
        ([attrs.evolve(mirror(curved=True), positions=np.zeros((4, 3)))], "a curved mirror of no size"),
        ([attrs.evolve(mirror(), body=1)], "a mirror that moves"),
        ([mirror((0, 0, -k)) for k in range(9)], "9 mirrors: expected at most 8"),
    ],
)
def test_mirrors_that_cannot_be_drawn_are_refused(meshes, message):
    with pytest.raises(SceneError, match=message):
        scene_of(*meshes, bodies=(Body("cart", Still(RigidState(Pose()))),))


QUAD = Quad((0, 1.6, -1), (0.3, 0, 0), (0, 0.3, 0), -1, (1, 1, 1)).mesh("quad")


def repeated(triangles: int, **changes: object) -> Mesh:
    return attrs.evolve(QUAD, triangles=np.resize(QUAD.triangles, (triangles, 3)), **changes)


def waving(vertices: int) -> Mesh:
    points = np.zeros((vertices, 3), np.float32)
    uv, light = np.zeros((vertices, 2), np.float32), np.ones((vertices, 3), np.float32)
    flag = Waving(points, np.linspace(0, 1, vertices), (0, 0, 1), 0.1, 1.0, 1.0)
    return Mesh("flag", points, points, uv, light, QUAD.triangles, deformation=flag)


def test_shipped_scenes_are_not_slow():
    assert all(slow_in(load_scene(name)) == () for name in scenes.names())


@pytest.mark.parametrize(
    ("scene", "line"),
    [
        (Scene("s", "", [repeated(249_999)]), None),
        (Scene("s", "", [repeated(200_000), repeated(50_000)]), "250,000 triangles: simplify"),
        (Scene("s", "", [repeated(20_000)]), None),
        (Scene("s", "", [repeated(20_000, material=Material(see_through=True))]), "20,000 transparent triangles: "),
        (Scene("s", "", [QUAD], bodies=[Body("b", Spinning(Pose(), (0, 1, 0), 1.0))] * 120), "120 moving bodies: "),
        (Scene("s", "", [QUAD], [Texture("t", np.zeros((1, 1, 3), np.uint8))] * 600), "600 textures: "),
        (Scene("s", "", [waving(60_000)]), "60,000 moving vertices: "),
    ],
)
def test_excess_is_reported_with_its_count(scene, line):
    found = slow_in(scene)
    assert len(found) == (line is not None) and all(text.startswith(line) for text in found)
