"""One way in for every scene: a registered name or a user's file."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from ..registry import unknown_name
from ._scene import Scene, SceneSource, scenes

FILE_ENDINGS = (".glb", ".obj", ".ply")


def load_scene(name_or_path: str | Path) -> Scene:
    """Load the scene registered under a name, else the GLB, OBJ or PLY file at a path.

    A registered scene is built once and kept; its arrays are read-only.

    Errors: UnknownNameError (with the nearest known name) for what is neither; SceneError for a
    file that cannot be used.
    """
    text = str(name_or_path)
    if text in scenes.names():
        return _built(scenes.get(text))
    path = Path(name_or_path)
    if path.suffix.lower() in FILE_ENDINGS or path.is_file():
        from ._files import scene_from_file

        return scene_from_file(path)
    raise unknown_name("scene", text, [*scenes.names(), *(f"FILE{ending}" for ending in FILE_ENDINGS)])


@cache
def _built(source: SceneSource) -> Scene:
    return source.build()
