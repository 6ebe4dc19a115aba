"""Shared by the scenes on a deck one floor up: sky and the textures of deck, store and country."""

from __future__ import annotations

from .._mesh import Texture
from .._scene import Background
from ..textures import textures_named

SKY = Background((0.13, 0.30, 0.66), (0.68, 0.78, 0.90), (0.30, 0.34, 0.22))


def deck_textures(*more: str) -> list[Texture]:
    """Paint the textures of the deck, then those of these names."""
    country = ("foliage", "grass", "roof", "facade", "map", "posters")
    return textures_named("planks", "wood", "bricks", "plaster", "fabric", "speckle", *country, *more)
