"""What the window shows: meadow, fence, trees and houses as real geometry at 8 to 200 m, lit by a plain sun from the right."""

from __future__ import annotations

import numpy as np

from ._paint import fractal
from ._pieces import OUTSIDE, Pieces
from ._surfaces import Surface, box, cushion, join, leaf, patch, sheet, tube

GROUND_M = -3.2  # the room is on the first floor
TOWARDS_SUN = np.array([0.74, 0.58, 0.34])
SUN, SKY, HAZE = np.array([0.78, 0.70, 0.56]), np.array([0.26, 0.31, 0.38]), np.array([0.55, 0.65, 0.80])


def daylight(surface: Surface, *, two_sided: bool = False) -> np.ndarray:
    """(n, 3) light of sun and sky outdoors; a simple stand-in for haze lightens what is far."""
    cosine = surface.normals @ TOWARDS_SUN
    sun = np.abs(cosine) * 0.6 + 0.25 if two_sided else np.maximum(cosine, 0)
    sky = 0.62 + 0.38 * surface.normals[:, 1]
    light = sun[:, None] * SUN + sky[:, None] * SKY * 1.25
    clear = np.exp(-np.linalg.norm(surface.positions, axis=1) / 260)[:, None]
    return light * clear + HAZE * (1 - clear)


def build_outside(pieces: Pieces, rng: np.random.Generator) -> None:
    """All of it, in front of the window only."""
    _ground(pieces)
    # x, z, width, height, turn
    houses = [(-15, -34, 9, 6, 0.3), (8.4, -31, 9, 6, 0.15), (24, -36, 10, 7, -0.35), (-4, -56, 10, 7, 0.1), (14, -62, 10, 8, -0.1),
              (34, -60, 12, 7, -0.2), (-26, -62, 12, 8, 0.3)]  # fmt: skip
    for i, house in enumerate(houses):
        _house(pieces, i, house)
    trees = [(-3.0, -15, 4.6), (9.6, -16, 4.9), (-13, -24, 6.4), (1.0, -44, 8), (16.5, -26, 5.6), (30, -44, 8.5), (-11, -46, 8),
             (3.4, -23, 3.0)]  # fmt: skip
    for x, z, height in trees:
        _tree(pieces, rng, x, z, height)
    _fence(pieces)
    _hills(pieces)


def _ground(pieces: Pieces) -> None:
    meadow = patch((-110, GROUND_M, -6), (220, 0, 0), (0, 0, -160), cell_m=10, tile_m=5)
    pieces.add(meadow, "grass", (0.85, 0.95, 0.75), place=OUTSIDE, shades=False)
    road = patch((-110, GROUND_M + 0.04, -25.5), (220, 0, 0), (0, 0, -3.2), cell_m=10, tile_m=2.5)
    pieces.add(road, "speckle", (0.42, 0.40, 0.38), place=OUTSIDE, shades=False)


def _house(pieces: Pieces, index: int, where: tuple[float, float, float, float, float]) -> None:
    x, z, wide, high, turn = where
    place, deep, wall = (x, GROUND_M, z), wide * 0.8, high * 0.72
    tint = ((0.95, 0.88, 0.72), (0.80, 0.52, 0.42), (0.92, 0.92, 0.90), (0.70, 0.78, 0.74), (0.95, 0.80, 0.56))[
        index % 5
    ]
    pieces.add(
        box((0, wall / 2, 0), (wide, wall, deep), cell_m=3, uv=(0, 0, 1, 0.667), without="-y+y").moved(place, turn),
        "facade",
        tint,
        place=OUTSIDE,
    )
    over, ridge = 0.35, high
    slopes = []
    for side in (1, -1):
        corner = (-(wide / 2 + over) * side, wall - 0.25, (deep / 2 + over) * side)
        slopes.append(
            patch(
                corner,
                ((wide + 2 * over) * side, 0, 0),
                (0, ridge - wall + 0.25, -(deep / 2 + over) * side),
                cell_m=2.5,
                tile_m=3,
            )
        )
    pieces.add(join(slopes).moved(place, turn), "roof", (1.0, 0.95, 0.9), place=OUTSIDE, double_sided=True)
    gables = []
    for side in (1, -1):
        points = np.array(
            [
                [(side * wide / 2, ridge - 0.25, 0)] * 3,
                [(side * wide / 2, wall - 0.12, z * side) for z in (deep / 2, 0, -deep / 2)],
            ]
        )
        gables.append(sheet(points, np.array([[(0.02, 0.98)] * 3, [(0.0, 0.92), (0.05, 0.92), (0.1, 0.92)]])))
    gable = join(gables)
    outwards = np.sign(gable.positions[:, :1]) * np.array([1.0, 0, 0])
    gable = Surface(gable.positions, outwards, gable.uv, gable.triangles)
    pieces.add(gable.moved(place, turn), "facade", tint, place=OUTSIDE, double_sided=True)
    pieces.add(
        box((wide * 0.22, high * 0.98, 0), (0.7, high * 0.3, 0.7), tile_m=1.2, without="-y").moved(place, turn),
        "bricks",
        place=OUTSIDE,
    )


def _tree(pieces: Pieces, rng: np.random.Generator, x: float, z: float, height: float) -> None:
    base = np.array([x, GROUND_M, z])
    pieces.add(
        tube(
            [base, base + (0.05, height * 0.3, 0), base + (0, height * 0.7, 0.05)],
            (0.035 * height, 0.026 * height, 0.012 * height),
            tile_m=0.8,
        ),
        "wood",
        (0.5, 0.45, 0.42),
        place=OUTSIDE,
    )
    crown, cards = [], []
    for i in range(3):
        offset = np.array([rng.normal(0, 0.15), 0.48 + 0.17 * i, rng.normal(0, 0.16)]) * height
        blob = cushion(
            (0, 0, 0),
            np.array([0.52, 0.40, 0.52]) * height * (1.08 - 0.17 * i),
            roundness=1,
            rings=8,
            sides=12,
            tile_m=0.9,
        )
        rough = (
            1
            + 0.22 * np.sin(blob.positions @ rng.normal(0, 7 / height, 3) * 3)
            + 0.14 * np.sin(blob.positions @ rng.normal(0, 14 / height, 3) * 3)
        )
        crown.append(Surface(blob.positions * rough[:, None] + base + offset, blob.normals, blob.uv, blob.triangles))
        for _ in range(20):
            way = rng.normal(0, 1, 3)
            way /= np.linalg.norm(way)
            at = base + offset + way * np.array([0.26, 0.20, 0.26]) * height * (1.08 - 0.17 * i)
            cards.append(
                leaf(at, way + rng.normal(0, 0.4, 3), length=0.10 * height, width=0.07 * height, droop=0.3, cells=2)
            )
    tint = np.array((0.42, 0.55, 0.28)) * rng.uniform(0.8, 1.15)
    pieces.add(join(crown), "foliage", tuple(tint), place=OUTSIDE)
    pieces.add(join(cards), "foliage", tuple(tint * 1.15), place=OUTSIDE, double_sided=True)


def _fence(pieces: Pieces) -> None:
    posts = [box((x, GROUND_M + 0.55, -12.5 - 0.02 * x), (0.12, 1.1, 0.08), cell_m=2) for x in np.arange(-8, 22, 0.9)]
    rails = [box((7, GROUND_M + y, -12.55), (31, 0.09, 0.05), cell_m=6).moved((0, 0, 0), 0.02) for y in (0.4, 0.85)]
    pieces.add(join(posts + rails), "wood", (0.95, 0.9, 0.85), place=OUTSIDE)


def _hills(pieces: Pieces) -> None:
    angle = np.linspace(-1.15, 1.15, 81)
    for distance, high, seed, tint in ((150, 13, 700, (0.50, 0.62, 0.42)), (205, 24, 701, (0.52, 0.62, 0.66))):
        ridge = high * (0.6 + 0.25 * fractal(1, 128, seed, 1.2)[0, :81])
        top = np.stack([distance * np.sin(angle), ridge, -distance * np.cos(angle)], axis=-1)
        low = np.stack(
            [distance * 0.93 * np.sin(angle), np.full(81, GROUND_M - 1), -distance * 0.93 * np.cos(angle)], axis=-1
        )
        points = np.stack([top, (top + low) / 2, low])
        uv = np.stack(
            [
                np.broadcast_to(angle * distance / 14, (3, 81)),
                np.broadcast_to(np.array([[2.0], [1.0], [0.0]]), (3, 81)),
            ],
            axis=-1,
        )
        pieces.add(sheet(points, uv), "grass", tint, place=OUTSIDE, shades=False)
