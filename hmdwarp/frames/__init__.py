"""Frames: what the server drew, with the exact views it was drawn for.

The kinds of layers are registered in frames.layers.
"""

from .frame import EyeImage, Frame, Needs, frame_bytes, video_pixels
from .layers import EyeSizes, Surface
from .layers.ids import BodyIds
from .layers.others import Others
from .layers.reflection import Mirrored, Reflection
from .layers.transparent import Transparent

__all__ = [
    "BodyIds",
    "EyeImage",
    "EyeSizes",
    "Frame",
    "Mirrored",
    "Needs",
    "Others",
    "Reflection",
    "Surface",
    "Transparent",
    "frame_bytes",
    "video_pixels",
]
