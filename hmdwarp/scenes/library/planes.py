"""Textured planes at known depths, one slanted, before an empty sky: known exactly."""

from __future__ import annotations

from .._mesh import Texture
from .._scene import Background, Scene
from ..shapes import Quad, checker
from . import SceneSource, scenes

QUADS = (
    Quad((-0.5, 1.5, -1.0), (0.35, 0, 0), (0, 0.35, 0), 0, (1.0, 0.75, 0.6)),
    Quad((0.55, 1.9, -2.0), (0.5, 0, 0), (0, 0.4, 0), 1, (0.6, 0.9, 1.0)),
    Quad((0.9, 1.2, -3.2), (0.8, 0, -0.9), (0, 0.8, 0), 0, (0.75, 1.0, 0.7), (2, 2)),
    Quad((0.0, 0.0, -6.0), (5.0, 0, 0), (0, 0, -6.0), 1, (0.8, 0.75, 0.7), (8, 9)),
    Quad((-1.5, 3.0, -12.0), (4.0, 0, 0), (0, 3.0, 0), 0, (0.9, 0.9, 0.9), (4, 3)),
)
BACKGROUND = Background((0.10, 0.22, 0.55), (0.55, 0.65, 0.80), (0.20, 0.19, 0.17))
SUMMARY = "five textured planes at known depths, one slanted, before an empty sky (analytic, for tests)"


def build() -> Scene:
    """Return the planes as two triangles each."""
    textures = (
        Texture("checker", checker(8, 32, (40, 44, 60), (228, 220, 205), 1)),
        Texture("checker-fine", checker(16, 16, (90, 50, 40), (245, 235, 220), 2)),
    )
    meshes = [quad.mesh(f"plane-{i}") for i, quad in enumerate(QUADS)]
    return Scene("planes", SUMMARY, meshes, textures, BACKGROUND)


scenes.register(SceneSource("planes", SUMMARY, build))
