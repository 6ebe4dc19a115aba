"""The server: draw a scene for the eyes into a Frame. It knows no latency, warps or lenses."""

from .draw import MIRRORS, Server
from .passes import ArrivingLight, Indirect, Lighting, ScenePasses, clear_depth, draw_moving
from .targets import BYTES_BINDING, Framebuffers, Multisampled, Renderer, Target, TargetPool, display_bytes
from .upload import DeformingMesh, SceneBuffers, SceneTextures, moving_parts
from .visibility import Visibility, boxes_of, clip_from_eye, draws_of, eye_from_scene

__all__ = [
    "BYTES_BINDING",
    "MIRRORS",
    "ArrivingLight",
    "DeformingMesh",
    "Framebuffers",
    "Indirect",
    "Lighting",
    "Multisampled",
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
