"""Rooms of boxes and walls with places in the light atlas, for scenes whose light moves."""

from __future__ import annotations

from collections.abc import Iterable

import attrs
import numpy as np

from .._mesh import Mesh, Texture
from .._scene import ATLAS
from ..shapes import Quad, Triple, checker

BORDER = 1  # texels around each chart, so that light never blends with another's


def textures() -> tuple[Texture, ...]:
    """Return plaster and planks, as far as a checkerboard is either."""
    return (
        Texture("plaster", checker(16, 16, (205, 200, 192), (225, 220, 212), 3)),
        Texture("tiles", checker(16, 16, (120, 112, 104), (216, 206, 190), 4)),
    )


def wall(centre: Triple, right: Triple, up: Triple, albedo: Triple, texture: int = 0) -> Quad:
    """Return a wall with half edges right and up, its texture 2 m wide."""
    sides = (float(np.linalg.norm(right)), float(np.linalg.norm(up)))
    return Quad(centre, right, up, texture, albedo, sides)


def box(low: Triple, high: Triple, albedo: Triple, texture: int = 0) -> list[Quad]:
    """Return the sides of a box and its top; it stands on the floor."""
    middle, half = (np.array(low) + high) / 2, (np.array(high) - low) / 2
    x, y, z = np.diag(half)
    outwards = ((x, -z, y), (-x, z, y), (z, x, y), (-z, -x, y), (y, x, -z))  # side, right, up
    return [wall(tuple(middle + side), tuple(right), tuple(up), albedo, texture) for side, right, up in outwards]


def in_atlas(quads: Iterable[Quad], texel_m: float) -> list[Mesh]:
    """Return the quads as meshes placed in the light atlas, tallest first; texel_m: about wide."""
    quads = list(quads)
    counts = [
        [max(1, round(2 * float(np.linalg.norm(half)) / texel_m)) for half in (quad.right, quad.up)] for quad in quads
    ]
    meshes: dict[int, Mesh] = {}
    column = row = tallest = 0
    for index in sorted(range(len(quads)), key=lambda i: -counts[i][1]):
        wide, high = counts[index]
        if column + wide + 2 * BORDER > ATLAS[0]:
            column, row, tallest = 0, row + tallest, 0
        low = np.array([column, row]) + BORDER
        corners = low + np.array([(0, 0), (wide, 0), (wide, high), (0, high)])
        meshes[index] = attrs.evolve(quads[index].mesh(f"surface-{index}"), light_uv=corners)
        column, tallest = column + wide + 2 * BORDER, max(tallest, high + 2 * BORDER)
    return [meshes[index] for index in range(len(quads))]
