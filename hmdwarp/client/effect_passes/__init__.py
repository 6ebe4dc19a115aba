"""Passes and parts that several effects share."""

from .closing import Closing
from .mirrored_pass import MirroredPass
from .motion_pass import MotionPass
from .panels_pass import PanelsPass
from .reflections import Reflections

__all__ = ["Closing", "MirroredPass", "MotionPass", "PanelsPass", "Reflections"]
