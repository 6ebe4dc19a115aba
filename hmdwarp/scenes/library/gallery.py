"""A gallery: an uneven polished floor, a wall mirror, a chrome ball among sculptures and pictures.

The floor mirrors as polished stone under wax (0.3; bare stone has 0.05). Its normal map is scaled
so that what is 3 m behind the floor sways by 5 cm.
"""

from __future__ import annotations

from .._scene import Background, Scene, SceneSource, scenes
from ._models import StoredModel, textures_named

SUMMARY = "a gallery with an uneven polished floor, a wall mirror and a chrome ball"
EFFECTS = ("planar_reflections", "glossy_reflections", "curved_reflections")
WALK_BOUNDS_M = ((-0.9, 0.9, -0.9), (0.9, 2.1, 1.5))
GREY = Background.uniform((0.5, 0.5, 0.5))  # never seen: the room is closed


def build() -> Scene:
    """Return the gallery; the same to the last bit every time."""
    textures = textures_named("marble", "plaster", "wood", "fabric", "speckle", "paintings", "floor-normals")
    meshes = StoredModel("gallery").meshes(textures)
    return Scene("gallery", SUMMARY, meshes, textures, GREY, walk_bounds_m=WALK_BOUNDS_M)


scenes.register(SceneSource("gallery", SUMMARY, build, EFFECTS))
