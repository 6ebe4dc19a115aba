"""Scenes: triangles, textures and baked light in plain arrays, and the effects they call for.

Every public module of `library` is one scene; a new scene is one new file there.
"""

from ._content import Body, Deformation, Material, Motion
from ._load import load_scene
from ._mesh import Mesh, Texture
from ._mirrors import SceneMirror
from ._reduce import reduced, unlit
from ._scene import Background, Scene, SceneSource, is_cutout, scenes
from ._slow import slow_in
from .deformations import Joint, Skinned, Waving
from .motions import Spinning, Thrown, Track
from .shapes import Ball, Quad, checker

__all__ = [
    "Background",
    "Ball",
    "Body",
    "Deformation",
    "Joint",
    "Material",
    "Mesh",
    "Motion",
    "Quad",
    "Scene",
    "SceneMirror",
    "SceneSource",
    "Skinned",
    "Spinning",
    "Texture",
    "Thrown",
    "Track",
    "Waving",
    "checker",
    "is_cutout",
    "load_scene",
    "reduced",
    "scenes",
    "slow_in",
    "unlit",
]
