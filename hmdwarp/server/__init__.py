"""The server: draws a scene for the eyes into a Frame.

It knows nothing of lateness, warps or lenses.
"""

from .draw import MIRRORS, Server
from .moving import moving_parts, stands_still
from .passes import ScenePasses, clear_depth
from .targets import Framebuffers, Target, TargetPool
from .upload import SceneBuffers, SceneTextures

__all__ = [
    "MIRRORS",
    "Framebuffers",
    "SceneBuffers",
    "ScenePasses",
    "SceneTextures",
    "Server",
    "Target",
    "TargetPool",
    "clear_depth",
    "moving_parts",
    "stands_still",
]
