"""Scenes: triangles, textures and baked light in plain arrays, and what each scene calls for. No GPU here.

Every public module of `library` is one scene; a new one is one new file there.
"""

from ._content import Body, Deformation, Material, Motion
from ._declared import is_cutout
from ._load import load_scene
from ._model import Background, Mesh, Scene, SceneSource, Texture, scenes
from .effects import SceneEffect

__all__ = [
    "Background",
    "Body",
    "Deformation",
    "Material",
    "Mesh",
    "Motion",
    "Scene",
    "SceneEffect",
    "SceneSource",
    "Texture",
    "is_cutout",
    "load_scene",
    "scenes",
]
