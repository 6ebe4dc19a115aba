"""Meshes become mirrors, and those that cannot be drawn are refused."""

from __future__ import annotations

import attrs
import numpy as np
import pytest

from hmdwarp.errors import SceneError
from hmdwarp.geometry import Pose, RigidState
from hmdwarp.scenes import Ball, Body, Material, Mesh, Quad, Scene, Still, Texture

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
