"""Kinds of warps: base classes and passes that warps, fills and effects build on."""

from .client_drawing import ClientDrawing
from .composite import CompositeWarp, DepthPicture
from .gather import GatherSettings, GatherWarp, bind_rendered_colour
from .grid_mesh import GridMesh
from .guesses import DepthGuesses, no_pieces, piece_list
from .homography import HomographyWarp
from .mesh import MeshWarp, steepest
from .plane import PlaneWarp
from .scatter import OrderedScatter, ScatterWarp, check_room
from .seeds import Seeds
from .tolerance import DEPTH_FLOOR, DEPTH_TOLERANCE, depth_limits

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
