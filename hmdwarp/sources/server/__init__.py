"""The server: draw a scene for the eyes into a Frame. It knows no latency, warps or lenses."""

from .byte_table import BYTES_BINDING, display_bytes
from .draw import MIRRORS, Server
from .lighting import ArrivingLight, Indirect, Lighting
from .moving import DeformingMesh, moving_parts
from .passes import ScenePasses, clear_depth, draw_moving
from .projection import boxes_of, clip_from_eye, eye_from_scene
from .targets import Framebuffers, Renderer, Target, TargetPool
from .upload import SceneBuffers, SceneTextures
from .visibility import Visibility, draws_of

__all__ = [
    "BYTES_BINDING",
    "MIRRORS",
    "ArrivingLight",
    "DeformingMesh",
    "Framebuffers",
    "Indirect",
    "Lighting",
    "Renderer",
    "SceneBuffers",
    "ScenePasses",
    "SceneTextures",
    "Server",
    "Target",
    "TargetPool",
    "Visibility",
    "boxes_of",
    "clear_depth",
    "clip_from_eye",
    "display_bytes",
    "draw_moving",
    "draws_of",
    "eye_from_scene",
    "moving_parts",
]
