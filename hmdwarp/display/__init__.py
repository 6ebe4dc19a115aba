"""Displays for live pictures: OpenXR, a desktop window, or offscreen.

The loop knows none of them; hmdwarp.run knows only the protocol re-exported here.
"""

from ._base import Closed, Command, Display, DisplayOptions, EyePicture, Label, Lost, Picture, TextPanel, Tick
from .controls import CONTROLS, Control, control
from .status import Status

__all__ = [
    "CONTROLS",
    "Closed",
    "Command",
    "Control",
    "Display",
    "DisplayOptions",
    "EyePicture",
    "Label",
    "Lost",
    "Picture",
    "Status",
    "TextPanel",
    "Tick",
    "control",
]
