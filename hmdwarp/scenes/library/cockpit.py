"""The cockpit of a small aircraft on a deck, and a head-up display that is fixed to the head."""

from __future__ import annotations

from ...geometry import Pose
from .._scene import Scene, SceneSource, scenes
from ._models import SKY, StoredModel, deck_textures

SUMMARY = "a cockpit with a view and a head-up display fixed to the head: overlay"
VIEWPOINT = Pose((0.0, 1.4, 0.0))
WALK_BOUNDS_M = ((-0.35, 0.9, -0.3), (0.35, 1.8, 0.5))


def build() -> Scene:
    """Return the cockpit; the same to the last bit every time."""
    textures = deck_textures("dials", "hud")
    meshes = StoredModel("cockpit").meshes(textures)
    return Scene("cockpit", SUMMARY, meshes, textures, SKY, viewpoint=VIEWPOINT, walk_bounds_m=WALK_BOUNDS_M)


scenes.register(SceneSource("cockpit", SUMMARY, build, ("overlay",)))
