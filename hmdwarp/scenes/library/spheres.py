"""Textured spheres near and far over a floor: curved depth and round silhouettes, known exactly."""

from __future__ import annotations

from .._mesh import Texture
from .._scene import Background, Scene
from ..shapes import Ball, Quad, checker
from . import SceneSource, scenes

BALLS = (
    Ball((-0.35, 1.45, -0.9), 0.22, 0, (1.0, 0.55, 0.45)),
    Ball((0.45, 1.75, -1.6), 0.3, 1, (0.5, 0.8, 1.0)),
    Ball((0.1, 1.0, -2.4), 0.45, 0, (0.6, 1.0, 0.55)),
    Ball((-1.8, 2.2, -5.0), 0.9, 1, (1.0, 0.9, 0.5)),
    Ball((3.0, 1.8, -9.0), 1.5, 0, (0.9, 0.6, 1.0)),
)
FLOOR = Quad((0.0, 0.0, -6.0), (8.0, 0, 0), (0, 0, -8.0), 1, (0.7, 0.7, 0.72), (8, 8))
BACKGROUND = Background((0.16, 0.28, 0.60), (0.62, 0.70, 0.82), (0.20, 0.19, 0.17))
SUMMARY = "five textured spheres over a floor before an empty sky (analytic, for tests)"


def build() -> Scene:
    """Return the spheres as fine triangles, and the floor."""
    textures = (
        Texture("checker", checker(8, 32, (60, 60, 70), (235, 230, 225), 3)),
        Texture("checker-fine", checker(16, 16, (110, 100, 95), (240, 238, 230), 4)),
    )
    meshes = [ball.mesh(f"ball-{i}") for i, ball in enumerate(BALLS)]
    return Scene("spheres", SUMMARY, [*meshes, FLOOR.mesh("floor")], textures, BACKGROUND)


scenes.register(SceneSource("spheres", SUMMARY, build))
