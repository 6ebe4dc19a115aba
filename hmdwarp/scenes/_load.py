"""One way in for every scene: a registered name or a user's file."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import attrs

from ..errors import InputError
from ..registry import unknown_name
from ._scene import Scene, SceneSource, scenes
from .options import SceneOptions

FILE_ENDINGS = (".glb", ".gltf", ".obj", ".ply")


def load_scene(name_or_path: str | Path, options: SceneOptions | None = None) -> Scene:
    """Load the scene registered under a name, else the glTF, OBJ or PLY file at a path.

    A registered scene is built once and kept; its arrays are read-only.

    options: of files alone. Errors: UnknownNameError (with the nearest known name) for what is
    neither; SceneError for a file that cannot be used; InputError for options that do not fit.
    """
    text, options = str(name_or_path), options or SceneOptions()
    if text in scenes.names():
        _refuse_options(text, options)
        return _built(scenes.get(text))
    check_scene_name(text)
    from ._files import scene_from_file

    return scene_from_file(Path(name_or_path), options)


def check_scene_name(text: str) -> None:
    """Raise UnknownNameError for what is neither a registered scene nor looks like a file."""
    path = Path(text)
    if text not in scenes.names() and path.suffix.lower() not in FILE_ENDINGS and not path.is_file():
        raise unknown_name("scene", text, [*scenes.names(), *(f"FILE{ending}" for ending in FILE_ENDINGS)])


def _refuse_options(name: str, options: SceneOptions) -> None:
    """Raise InputError for options that only make sense with a file."""
    for field in attrs.fields(SceneOptions):
        if getattr(options, field.name) != field.default:
            flag = field.metadata["options"][0].named(field.name).flag
            raise InputError(f"{flag} with scene '{name}': it is for scene files; leave it out")


@cache
def _built(source: SceneSource) -> Scene:
    return source.build()
