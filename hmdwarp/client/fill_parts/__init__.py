"""Passes and algorithms that several fills share."""

from .block_lights import BLOCK as BLOCK
from .block_lights import NEAR as NEAR
from .block_lights import OFF_PLANE as OFF_PLANE
from .block_lights import SAME_DEPTH as SAME_DEPTH
from .block_lights import SAME_SURFACE as SAME_SURFACE
from .block_lights import BlockLights as BlockLights
from .block_lights import sample_offsets as sample_offsets
from .hole_pieces import HoleFiller as HoleFiller
from .hole_pieces import HolePieces as HolePieces
from .keeper import BLOCK_SIDE as BLOCK_SIDE
from .keeper import BYTES_PER_PIXEL as BYTES_PER_PIXEL
from .keeper import Keeper as Keeper
from .keeper import Keyframe as Keyframe
from .keeper import Slot as Slot
from .keeper import covered as covered
from .keeper import is_new as is_new
from .keeper import most_redundant as most_redundant
from .keeper import most_useful as most_useful
from .keeper import overlapping as overlapping
from .keeper import place_in_block as place_in_block
from .keeper import seeds_for as seeds_for
