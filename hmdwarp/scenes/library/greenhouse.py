"""A small greenhouse on a deck: dusty, lettered and coloured panes, a picket fence of alpha.

Panes and fence are cut into cells of 0.3 m: sheets are sorted by triangle, and small ones sort
right.
"""

from __future__ import annotations

from ...geometry import Pose
from .._scene import Scene, SceneSource, scenes
from ._models import SKY, StoredModel, deck_textures

SUMMARY = "a greenhouse with dusty, lettered and coloured panes, and a picket fence of alpha outside: transparency"
VIEWPOINT = Pose((0.0, 1.5, 0.0))
WALK_BOUNDS_M = ((-0.8, 0.8, -0.8), (0.8, 2.0, 0.9))


def build() -> Scene:
    """Return the greenhouse; the same to the last bit every time."""
    textures = deck_textures("pane", "pane-plain", "leaded", "pickets")
    meshes = StoredModel("greenhouse").meshes(textures)
    return Scene("greenhouse", SUMMARY, meshes, textures, SKY, viewpoint=VIEWPOINT, walk_bounds_m=WALK_BOUNDS_M)


scenes.register(SceneSource("greenhouse", SUMMARY, build, ("transparency",)))
