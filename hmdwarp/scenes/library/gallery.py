"""A gallery: a polished floor that is not quite even, a wall mirror, a chrome ball among sculptures and pictures."""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

from ...geometry import Pose
from .._content import Material
from .._model import Background, Mesh, Scene, SceneSource, Texture, scenes
from ..effects import SceneEffect
from . import _gallery_paint, _paint
from ._bake import Occluders, lamp_light
from ._gallery_things import BALL_CENTRE, BALL_RADIUS, HIGH, LAMPS, LOW, MIRROR, WHITE, build_things
from ._pieces import GLOWING, Piece, Pieces, merged, surface_points
from ._shapes import Ball
from ._surfaces import Surface, box, patch

SUMMARY = "a gallery with an uneven polished floor, a wall mirror and a chrome ball"
EFFECTS = SceneEffect.PLANAR_REFLECTIONS | SceneEffect.GLOSSY_REFLECTIONS | SceneEffect.CURVED_REFLECTIONS
SEED = 80
FLOOR = Material(reflectivity=0.3)  # of polished stone under wax that one sees oneself in; bare stone has 0.05
RIPPLES = 0.035  # of the normal map's slopes: what is 3 m behind the floor sways by 5 cm
TILE_M = 3.2


def build() -> Scene:
    """The gallery; the same to the last bit every time."""
    pieces = Pieces()
    _walls(pieces)
    build_things(pieces)
    textures = _textures()
    index = {texture.name: i for i, texture in enumerate(textures)}
    floor = patch((LOW[0], 0, HIGH[2]), (HIGH[0] - LOW[0], 0, 0), (0, 0, LOW[2] - HIGH[2]), cell_m=0.2, tile_m=TILE_M)
    lit = [*pieces, Piece(floor, "marble", shades=False)]
    lights = _lights(lit)
    normals = index["floor-normals"]
    mirrors = [
        _mirror_mesh(
            "floor", floor, lights[-1], index["marble"], attrs.evolve(FLOOR, normal_map=normals, normal_scale=RIPPLES)
        ),
        _wall_mirror(index["speckle"]),
        _ball(index["speckle"]),
    ]
    meshes = [*merged(pieces, lights[:-1], index.__getitem__), *mirrors]
    walk = ((-0.9, 0.9, -0.9), (0.9, 2.1, 1.5))
    nothing = Background.uniform((0.5, 0.5, 0.5))  # the room is closed
    return Scene("gallery", SUMMARY, meshes, textures, nothing, viewpoint=Pose((0.0, 1.6, 0.0)), walk_bounds_m=walk)


def _walls(pieces: Pieces) -> None:
    (x0, _, z0), (x1, y1, z1) = LOW, HIGH
    wide, deep = x1 - x0, z1 - z0
    grey, warm = (0.72, 0.74, 0.76), (0.80, 0.70, 0.58)
    walls = (
        ((x0, 0, z0), (wide, 0, 0), (0.36, 0.46, 0.50)),
        ((x1, 0, z1), (-wide, 0, 0), warm),
        ((x0, 0, z1), (0, 0, -deep), grey),
        ((x1, 0, z0), (0, 0, deep), grey),
    )
    for corner, along, tint in walls:
        pieces.add(patch(corner, along, (0, y1, 0), cell_m=0.3, tile_m=1.6), "plaster", tint, shades=False)
    pieces.add(patch((x0, y1, z0), (wide, 0, 0), (0, 0, deep), cell_m=0.5, tile_m=1.6), "plaster", WHITE, shades=False)
    for z in np.arange(z0 + 1.0, z1, 2.0):
        pieces.add(
            box((0, y1 - 0.09, z), (wide, 0.18, 0.16), without="+y-x+x", cell_m=0.5),
            "wood",
            (0.5, 0.42, 0.34),
            shades=False,
        )
    skirting = [((x, 0.07, 0.5 * (z0 + z1)), (0.024, 0.14, deep)) for x in (x0 + 0.012, x1 - 0.012)]
    skirting += [((0, 0.07, z), (wide, 0.14, 0.024)) for z in (z0 + 0.012, z1 - 0.012)]
    for centre, size in skirting:
        pieces.add(box(centre, size, without="-y", cell_m=1.0), "speckle", WHITE, shades=False)


def _textures() -> list[Texture]:
    pictures = {
        "marble": _gallery_paint.marble(),
        "plaster": _paint.plaster(),
        "wood": _paint.wood(),
        "fabric": _paint.fabric(),
        "speckle": _paint.speckle(),
        "paintings": _gallery_paint.paintings(),
    }
    made = [Texture(name, image, repeat=name != "paintings") for name, image in pictures.items()]
    return [*made, Texture("floor-normals", _gallery_paint.ripples(), srgb=False)]


def _lights(pieces: list[Piece]) -> list[NDArray]:
    """Baked light of every vertex, piece by piece."""
    rng = np.random.default_rng(SEED)
    loose, walls = (
        np.concatenate([surface_points(p.surface, spacing, rng) for p in pieces if p.shades is shades])
        for spacing, shades in ((0.05, True), (0.06, False))
    )
    room = Occluders(LOW, HIGH, loose, walls)
    points = np.concatenate([p.surface.positions for p in pieces]).astype(np.float32)
    normals = np.concatenate([p.surface.normals for p in pieces]).astype(np.float32)
    two_sided = np.repeat([p.double_sided for p in pieces], [len(p.surface.positions) for p in pieces])
    upwards = normals[:, 1:2] * 0.5 + 0.5
    light = (
        np.array((0.27, 0.25, 0.23), np.float32) * (1 - upwards) + np.array((0.30, 0.30, 0.30), np.float32) * upwards
    )
    for lamp in LAMPS:
        light = light + lamp_light(room, points, normals, two_sided, lamp=lamp, colour=(1.15, 1.06, 0.94))
    light *= room.ambient(points, normals)[:, None]
    split = np.split(light, np.cumsum([len(p.surface.positions) for p in pieces])[:-1])
    return [np.ones_like(part) if piece.place == GLOWING else part for piece, part in zip(pieces, split, strict=True)]


def _mirror_mesh(name: str, surface: Surface, light: NDArray, texture: int, material: Material) -> Mesh:
    return Mesh(
        name, surface.positions, surface.normals, surface.uv, light, surface.triangles, texture, material=material
    )


def _wall_mirror(texture: int) -> Mesh:
    x, y, half_wide, half_high = MIRROR
    glass = patch(
        (x - half_wide, y - half_high, LOW[2] + 0.01), (2 * half_wide, 0, 0), (0, 2 * half_high, 0), cell_m=5.0
    )
    return _mirror_mesh(
        "wall-mirror", glass, np.full((len(glass.positions), 3), 0.05), texture, Material(reflectivity=0.9)
    )


def _ball(texture: int) -> Mesh:
    """Chrome; its own colour, a grey with a bright top, is what it has in the mirrors."""
    plain = Ball(BALL_CENTRE, BALL_RADIUS, texture, (0.34, 0.34, 0.36)).mesh("chrome-ball", rings=40)
    return attrs.evolve(plain, material=Material(reflectivity=0.85, curved=True))


scenes.register(SceneSource("gallery", SUMMARY, build, EFFECTS))
