"""Passes and algorithms that several fills share."""

from .block_lights import (
    BLOCK,
    NEAR,
    OFF_PLANE,
    PARTS,
    SAME_DEPTH,
    SAME_SURFACE,
    BlockLights,
    sample_offsets,
)
from .hole_pieces import HoleFiller, HolePieces
from .keeper import (
    BLOCK_SIDE,
    BYTES_PER_PIXEL,
    Keeper,
    Keyframe,
    Slot,
    covered,
    is_new,
    most_redundant,
    most_useful,
    overlapping,
    place_in_block,
    seeds_for,
)

__all__ = [
    "BLOCK",
    "BlockLights",
    "NEAR",
    "OFF_PLANE",
    "PARTS",
    "SAME_DEPTH",
    "SAME_SURFACE",
    "sample_offsets",
    "BLOCK_SIDE",
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
    "place_in_block",
    "seeds_for",
]
