"""Kinds of warps, for those of other packages: base classes, and what they share."""

from .warps import ArrayWarp
from .warps.forward import OrderedScatter, ScatterWarp, check_room
from .warps.gather import (
    DEPTH_FLOOR,
    DEPTH_TOLERANCE,
    GatherSettings,
    GatherWarp,
    HomographyWarp,
    PlaneWarp,
    depth_limits,
)
from .warps.mesh import MeshWarp, steepest
from .warps.model import ClientDrawing
from .warps.multi import CompositeWarp

__all__ = [
    "DEPTH_FLOOR",
    "DEPTH_TOLERANCE",
    "ArrayWarp",
    "ClientDrawing",
    "CompositeWarp",
    "GatherSettings",
    "GatherWarp",
    "HomographyWarp",
    "MeshWarp",
    "OrderedScatter",
    "PlaneWarp",
    "ScatterWarp",
    "check_room",
    "depth_limits",
    "steepest",
]
