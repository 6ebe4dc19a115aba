"""Headsets: one .toml file each, with the source of its numbers.

All code that assumes two eyes and a panel is here.
"""

from ._load import headset_names, load_headset
from ._model import COLOURS, MAX_COEFFICIENTS, CameraDisplay, Headset, RadialLens, camera_display

__all__ = [
    "COLOURS",
    "MAX_COEFFICIENTS",
    "CameraDisplay",
    "Headset",
    "RadialLens",
    "camera_display",
    "headset_names",
    "load_headset",
]
