"""Kinds of warps: base classes and passes that warps, fills and effects build on."""

from .client_drawing import ClientDrawing as ClientDrawing
from .composite import CompositeWarp as CompositeWarp
from .composite import DepthPicture as DepthPicture
from .gather import DEPTH_FLOOR as DEPTH_FLOOR
from .gather import DEPTH_TOLERANCE as DEPTH_TOLERANCE
from .gather import GatherSettings as GatherSettings
from .gather import GatherWarp as GatherWarp
from .gather import HomographyWarp as HomographyWarp
from .gather import PlaneWarp as PlaneWarp
from .gather import depth_limits as depth_limits
from .guesses import DepthGuesses as DepthGuesses
from .guesses import Seeds as Seeds
from .guesses import no_pieces as no_pieces
from .guesses import piece_list as piece_list
from .mesh import GridMesh as GridMesh
from .mesh import MeshWarp as MeshWarp
from .mesh import steepest as steepest
from .scatter import OrderedScatter as OrderedScatter
from .scatter import ScatterWarp as ScatterWarp
from .scatter import check_room as check_room
