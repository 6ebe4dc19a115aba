"""Kinds of warps: base classes and passes that warps, fills and effects build on."""

from .client_drawing import ClientDrawing
from .composite import CompositeWarp, DepthPicture
from .gather import (
    DEPTH_FLOOR,
    DEPTH_TOLERANCE,
    GatherSettings,
    GatherWarp,
    HomographyWarp,
    PlaneWarp,
    bind_rendered_colour,
    depth_limits,
)
from .guesses import DepthGuesses, Seeds, no_pieces, piece_list
from .mesh import GridMesh, MeshWarp, steepest
from .scatter import OrderedScatter, ScatterWarp, check_room

__all__ = [
    "DEPTH_FLOOR",
    "DEPTH_TOLERANCE",
    "depth_limits",
    "CompositeWarp",
    "DepthGuesses",
    "DepthPicture",
    "ClientDrawing",
    "GatherSettings",
    "GatherWarp",
    "GridMesh",
    "HomographyWarp",
    "MeshWarp",
    "OrderedScatter",
    "PlaneWarp",
    "ScatterWarp",
    "Seeds",
    "bind_rendered_colour",
    "check_room",
    "no_pieces",
    "piece_list",
    "steepest",
]
