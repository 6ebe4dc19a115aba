"""Passes and parts that several effects share."""

from .closing import Closing
from .mirrored_pass import MirroredPass
from .motion_pass import REACH_M, REACH_S, MotionPass
from .reflections import Reflections

__all__ = ["REACH_M", "REACH_S", "Closing", "MirroredPass", "MotionPass", "Reflections"]
