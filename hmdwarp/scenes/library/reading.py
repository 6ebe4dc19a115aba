"""A page of text in a bare room, partly behind a post, and a label that is fixed to the head."""

from __future__ import annotations

from ...geometry import Pose
from .._panels import Panel
from .._scene import Background, Scene
from ..shapes import Quad
from . import SceneSource, scenes
from ._models import textures_named

SUMMARY = "a page of text behind a post, and a label fixed to the head, which turn over: panels, occluded_panels"
QUADS = (
    Quad((0.0, 0.0, -3.0), (5.0, 0, 0), (0, 0, -6.0), 0, (0.8, 0.75, 0.7), (5, 6)),
    Quad((0.0, 1.5, -5.0), (5.0, 0, 0), (0, 1.5, 0), 1, (0.8, 0.8, 0.85), (3, 1)),
    Quad((0.38, 1.2, -1.15), (0.04, 0, 0), (0, 1.2, 0), 2, (0.8, 0.6, 0.45), (1, 8)),
)
BACKGROUND = Background.uniform((0.25, 0.27, 0.3))
PAGE_S = 4.0  # of a page
PAGE_POSE = Pose((0.1, 1.55, -1.6), (0.0, 0.0499792, 0.0, 0.9987503))  # turned by 0.1 rad
LABEL_POSE = Pose((0.0, -0.3, -1.2))


def build() -> Scene:
    """Return the room; the same to the last bit every time."""
    pages, labels = (textures_named(*(f"{name}-{number}" for number in (1, 2))) for name in ("page", "label"))
    panels = [
        Panel(pages, PAGE_POSE, (1.0, 0.5742), occluded=True, seconds=PAGE_S),
        Panel(labels, LABEL_POSE, (0.284, 0.048), head_locked=True, seconds=PAGE_S),
    ]
    meshes = [quad.mesh(f"surface-{i}") for i, quad in enumerate(QUADS)]
    textures = textures_named("planks", "plaster", "wood")
    return Scene("reading", SUMMARY, meshes, textures, BACKGROUND, panels=panels)


scenes.register(SceneSource("reading", SUMMARY, build, ("panels", "occluded_panels")))
