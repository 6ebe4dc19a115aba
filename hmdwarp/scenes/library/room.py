"""A furnished room by daylight with a view: near, far and thin things, fine texture everywhere."""

from __future__ import annotations

from .._scene import Scene, SceneSource, scenes
from ._models import SKY, StoredModel, textures_named

SUMMARY = (
    "a furnished room with a window view: fine texture, thin, near (0.4 m) and far (beyond 20 m) things, baked light"
)
WALK_BOUNDS_M = ((-1.6, 0.8, -1.6), (1.6, 2.2, 1.6))


def build() -> Scene:
    """Return the room; the same to the last bit every time."""
    textures = textures_named("planks", "wood", "bricks", "wallpaper", "plaster", "fabric", "speckle", "foliage")
    textures += textures_named("grass", "roof", "facade", "mesh", "map", "books", "posters", "sun-floor")
    meshes = StoredModel("room").meshes(textures)
    return Scene("room", SUMMARY, meshes, textures, SKY, walk_bounds_m=WALK_BOUNDS_M)


scenes.register(SceneSource("room", SUMMARY, build))
