"""One way in for every scene: a registered name or a user's file."""

from __future__ import annotations

from pathlib import Path

import attrs

from ..errors import InputError
from ..registry import unknown_name
from ._scene import Scene, scenes
from .options import SceneOptions

FILE_ENDINGS = (".glb", ".gltf", ".obj", ".ply")


def load_scene(name_or_path: str | Path, options: SceneOptions | None = None) -> Scene:
    """Load the scene registered under a name, else the glTF, OBJ or PLY file at a path.

    options: of files alone. Errors: UnknownNameError (with the nearest known name) for what is
    neither; SceneError for a file that cannot be used; InputError for options that do not fit.
    """
    text, options = str(name_or_path), options or SceneOptions()
    if text in scenes.names():
        _refuse_options(text, options)
        return scenes.get(text).build()
    path = Path(name_or_path)
    if path.suffix.lower() in FILE_ENDINGS or path.is_file():
        from ._files import scene_from_file

        return scene_from_file(path, options)
    raise unknown_name("scene", text, [*scenes.names(), *(f"FILE{ending}" for ending in FILE_ENDINGS)])


def _refuse_options(name: str, options: SceneOptions) -> None:
    """Raise InputError for options that only make sense with a file."""
    for field in attrs.fields(SceneOptions):
        if getattr(options, field.name) != field.default:
            flag = field.metadata["options"][0].named(field.name).flag
            raise InputError(f"{flag} with scene '{name}': it is for scene files; leave it out")
