"""What makes a scene slow is told in a line each, with its count."""

from __future__ import annotations

import attrs
import numpy as np
import pytest

from hmdwarp.geometry import Pose
from hmdwarp.scenes import Body, Material, Mesh, Quad, Scene, Spinning, Texture, Waving, load_scene, scenes, slow_in

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
