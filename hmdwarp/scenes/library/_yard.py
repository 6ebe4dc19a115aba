"""A deck one floor up, open to the sky, walled on three sides and with a view: where things that move stand before a calm background."""

from __future__ import annotations

import numpy as np

from .._model import Background, Texture
from . import _paint, _print
from ._bake import Occluders
from ._pieces import INSIDE, Piece, Pieces, surface_points
from ._room_outside import TOWARDS_SUN, build_outside, daylight
from ._surfaces import Surface, box, cushion, lathe, patch, tube

LOW, HIGH = np.array([-4.0, 0.0, -6.0]), np.array([4.0, 2.9, 2.6])
SKY_BACKGROUND = Background((0.13, 0.30, 0.66), (0.68, 0.78, 0.90), (0.30, 0.34, 0.22))
SHADE_M = 3.5  # how far towards the sun shadows are looked for
STEEL, DARK = (0.36, 0.37, 0.39), (0.10, 0.10, 0.11)


def build_yard(pieces: Pieces, rng: np.random.Generator) -> None:
    """The deck, its walls and parapet, and the country around."""
    build_outside(pieces, rng)
    (x0, _, z0), (x1, high, z1) = LOW, HIGH
    deck = patch((x0, 0, z1), (x1 - x0, 0, 0), (0, 0, z0 - z1), cell_m=0.16, tile_m=2.0)
    pieces.add(deck, "planks", (0.80, 0.78, 0.76), shades=False)
    pieces.add(patch((x0, 0, z1), (0, 0, z0 - z1), (0, high, 0), cell_m=0.3), "bricks", shades=False)
    pieces.add(
        patch((x1, 0, z0), (0, 0, z1 - z0), (0, high, 0), cell_m=0.3, tile_m=1.6),
        "plaster",
        (0.86, 0.80, 0.68),
        shades=False,
    )
    pieces.add(patch((x1, 0, z1), (x0 - x1, 0, 0), (0, high, 0), cell_m=0.4), "bricks", shades=False)
    pieces.add(box((0, 0.36, z0), (x1 - x0, 0.72, 0.2), cell_m=0.3, without="-y-x+x"), "bricks", shades=False)
    pieces.add(
        box((0, 0.75, z0), (x1 - x0, 0.06, 0.3), cell_m=0.5, without="-x+x"), "plaster", (0.8, 0.8, 0.78), shades=False
    )
    for x in (-3.94, 3.94):
        pieces.add(
            box((x, high + 0.03, -1.7), (0.3, 0.06, z1 - z0), cell_m=0.6), "plaster", (0.8, 0.8, 0.78), shades=False
        )


def barrel(centre: tuple[float, float, float], radius: float, height: float) -> Surface:
    """With bulging staves and a lid."""
    share = np.array([0, 0.08, 0.3, 0.5, 0.7, 0.92, 1.0])
    profile = [(radius * (1 - 0.55 * (s - 0.5) ** 2), height * s) for s in share]
    return lathe([(1e-3, 0.0), *profile, (radius * 0.8, height), (1e-3, height)], centre, sides=28, repeats=4)


def lean(start: tuple, end: tuple, radius: float) -> Surface:
    """A round bar from one place to the other."""
    return tube([start, (np.array(start) + np.array(end)) / 2, end], radius, sides=10)


def build_store(pieces: Pieces, rng: np.random.Generator) -> None:
    """Barrels, crates, sacks and bars along the walls: fine texture behind and beside what moves."""
    for x, z, radius, high in (
        (-3.5, -5.3, 0.36, 0.95),
        (-2.7, -5.45, 0.33, 0.85),
        (-3.45, -4.4, 0.3, 0.8),
        (3.5, -5.4, 0.36, 0.95),
    ):
        pieces.add(barrel((x, 0, z), radius, high), "wood", (0.75, 0.66, 0.55))
    for x, y, z, side, turn in (
        (3.3, 0.3, -4.3, 0.6, 0.2),
        (3.35, 0.8, -4.32, 0.4, -0.3),
        (2.6, 0.25, -5.4, 0.5, 0.5),
        (-1.6, 0.22, -5.55, 0.44, -0.2),
        (-3.55, 0.25, -2.8, 0.5, 0.1),
        (3.45, 0.35, -1.6, 0.7, 0.1),
    ):
        pieces.add(
            box((0, 0, 0), (side, side, side), cell_m=0.15, uv=(0, 0, 1, 1)).moved((x, y, z), turn),
            "wood",
            (1.1, 1.0, 0.85),
        )
    for x, z in ((0.9, -5.5), (1.45, -5.55), (1.15, -5.2)):
        pieces.add(cushion((x, 0.2, z), (0.62, 0.42, 0.42), roundness=0.5), "fabric", (0.70, 0.60, 0.42))
    for k in range(6):
        foot, top = rng.uniform(-0.15, 0.15), rng.uniform(-0.1, 0.1)
        pieces.add(
            lean((-3.75, 0.0, -1.7 + 0.3 * k + foot), (-3.97, 2.3, -1.6 + 0.28 * k + top), 0.02), "speckle", STEEL
        )
    for k in range(4):
        uv = (k / 4 + 0.002, 0.004, (k + 1) / 4 - 0.002, 0.996)
        at = (-3.985, 1.25, -2.4 - 0.72 * k)
        pieces.add(patch(at, (0, 0, -0.56), (0, 0.84, 0), cell_m=0.2, uv=uv), "posters", shades=False)


def yard_textures() -> list[Texture]:
    """All that the yard and what moves in it are painted with."""
    pictures = {
        "planks": _paint.planks(),
        "wood": _paint.wood(),
        "bricks": _paint.bricks(),
        "plaster": _paint.plaster(),
        "fabric": _paint.fabric(),
        "speckle": _paint.speckle(),
        "foliage": _paint.foliage(),
        "grass": _paint.grass(),
        "roof": _paint.roof(),
        "facade": _paint.facade(),
        "map": _paint.globe(),
        "posters": _print.posters(),
    }
    return [Texture(name, image) for name, image in pictures.items()]


def yard_lights(pieces: list[Piece], seed: int) -> list[np.ndarray]:
    """Baked light of every vertex, piece by piece: sun with soft shadows, sky, dark corners."""
    rng = np.random.default_rng(seed)
    on_deck = [piece for piece in pieces if piece.place == INSIDE]
    loose = np.concatenate([surface_points(p.surface, 0.05, rng) for p in on_deck if p.shades])
    walls = np.concatenate([surface_points(p.surface, 0.06, rng) for p in on_deck if not p.shades])
    around = Occluders(LOW, HIGH, loose, walls)
    return [_shaded(piece, around) if piece.place == INSIDE else _plain(piece) for piece in pieces]


def _plain(piece: Piece) -> np.ndarray:
    return daylight(piece.surface, two_sided=piece.double_sided)


def _shaded(piece: Piece, around: Occluders) -> np.ndarray:
    points, normals = (array.astype(np.float32) for array in (piece.surface.positions, piece.surface.normals))
    sun = TOWARDS_SUN / np.linalg.norm(TOWARDS_SUN)
    passes = around.transit(points, normals, points + np.float32(SHADE_M) * sun.astype(np.float32))
    light = daylight(piece.surface, two_sided=piece.double_sided)
    unlit = light * np.array((0.42, 0.47, 0.55))
    return (unlit + (light - unlit) * passes[:, None]) * around.ambient(points, normals)[:, None]


def body_lights(pieces: list[Piece]) -> list[np.ndarray]:
    """For what moves: sun and sky as in its first pose, no shadows."""
    return [_plain(piece) for piece in pieces]
