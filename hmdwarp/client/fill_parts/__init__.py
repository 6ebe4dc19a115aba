"""Passes and algorithms that several fills share."""

from .hole_filler import HoleFiller
from .hole_pieces import HolePieces
from .keeper import BYTES_PER_PIXEL, Keeper, Slot, seeds_for
from .keyframes import Keyframe, covered, is_new, most_redundant, most_useful, overlapping

__all__ = [
    "BYTES_PER_PIXEL",
    "HoleFiller",
    "HolePieces",
    "Keeper",
    "Keyframe",
    "Slot",
    "covered",
    "is_new",
    "most_redundant",
    "most_useful",
    "overlapping",
    "seeds_for",
]
