"""What stands and hangs in the gallery: pictures in frames, pedestals, sculptures, a bench, lamps."""

from __future__ import annotations

import numpy as np

from ._gallery_paint import place_of_painting
from ._pieces import GLOWING, Pieces
from ._surfaces import Surface, box, cushion, join, lathe, patch, tube

WHITE, BRONZE, STONE, BLACK = (0.86, 0.85, 0.82), (0.42, 0.28, 0.13), (0.80, 0.76, 0.68), (0.06, 0.06, 0.065)
GOLD, OAK, LINEN = (0.72, 0.52, 0.20), (0.62, 0.50, 0.36), (0.45, 0.42, 0.38)
LOW, HIGH = np.array([-4.0, 0.0, -5.5]), np.array([4.0, 3.6, 4.5])
MIRROR = (0.55, 1.55, 0.62, 1.05)  # centre x, y, half width, half height, on the wall at LOW z
BALL_CENTRE, BALL_RADIUS = (-0.62, 1.32, -2.15), 0.30
LAMPS = ((-2.4, 3.3, -3.6), (2.4, 3.3, -3.6), (-2.4, 3.3, 0.2), (2.4, 3.3, 0.2), (0.0, 3.3, 3.2))


def build_things(pieces: Pieces) -> None:
    """All of them."""
    _pictures(pieces)
    _mirror_frame(pieces)
    _pedestals(pieces)
    _bench(pieces)
    _lamps(pieces)
    _barrier(pieces)


def frame_of(width: float, height: float, bar: float, deep: float) -> Surface:
    """Four bars around a (width, height) opening in the plane z = 0, their front towards +z."""
    return join(
        [
            box((0, side * (height + bar) / 2, deep / 2), (width + 2 * bar, bar, deep), without="-z", cell_m=0.5)
            for side in (-1, 1)
        ]
        + [
            box((side * (width + bar) / 2, 0, deep / 2), (bar, height, deep), without="-z+y-y", cell_m=0.5)
            for side in (-1, 1)
        ]
    )


def _pictures(pieces: Pieces) -> None:
    """Three on each side wall, two beside the mirror, three behind the viewer."""
    near = 0.012
    quarter = np.pi / 2
    hung = [(0, (-2.2, 1.65, LOW[2]), 0.0, 1.5), (1, (2.75, 1.65, LOW[2]), 0.0, 1.35)]
    hung += [(2 + k, (LOW[0], 1.6, z), quarter, 1.1 + 0.15 * k) for k, z in enumerate((-3.9, -1.6, 1.2))]
    hung += [(5 + k, (HIGH[0], 1.6, z), -quarter, 1.25 - 0.12 * k) for k, z in enumerate((-3.7, -1.3, 1.4))]
    hung += [(k, (x, 1.7, HIGH[2]), 2 * quarter, 1.5) for k, x in ((3, -2.4), (0, 0.1), (6, 2.5))]
    for number, place, turn, high in hung:
        wide = high * 320 / 384
        canvas = patch(
            (-wide / 2, -high / 2, near), (wide, 0, 0), (0, high, 0), cell_m=0.3, uv=place_of_painting(number)
        )
        pieces.add(canvas.moved(place, turn), "paintings", shades=False)
        frame = frame_of(wide, high, 0.06, 0.045)
        pieces.add(frame.moved(place, turn), "wood", GOLD if number % 2 else BLACK)


def _mirror_frame(pieces: Pieces) -> None:
    x, y, half_wide, half_high = MIRROR
    pieces.add(frame_of(2 * half_wide, 2 * half_high, 0.09, 0.06).moved((x, y, LOW[2])), "wood", GOLD)


def _pedestals(pieces: Pieces) -> None:
    x, y, z = BALL_CENTRE
    top = y - BALL_RADIUS
    pieces.add(lathe([(0.12, top), (0.10, top + 0.025), (0.001, top + 0.02)], (x, 0, z), sides=24), "speckle", BLACK)
    for place, wide, high in (
        ((x, z), 0.42, top),
        ((1.75, -3.3), 0.5, 0.85),
        ((-2.6, -3.4), 0.6, 0.5),
        ((2.5, 2.6), 0.5, 0.9),
    ):
        pieces.add(box((place[0], high / 2, place[1]), (wide, high, wide), without="-y", cell_m=0.14), "plaster", WHITE)
    pieces.add(_knot().moved((1.75, 0.85 + 0.46, -3.3), 0.4), "speckle", BRONZE)
    pieces.add(_figure().moved((-2.6, 0.5, -3.4)), "plaster", STONE)
    pieces.add(_stack().moved((2.5, 0.9, 2.6)), "speckle", (0.16, 0.30, 0.42))


def _knot() -> Surface:
    """A trefoil in a thick rod."""
    t = np.linspace(0, 2 * np.pi, 97)
    path = np.stack([np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)], axis=1) * 0.135
    return tube(path, 0.062, sides=14)


def _figure() -> Surface:
    """A tall turned shape that leans and swells, as of worn stone."""
    height = np.linspace(0, 1.5, 40)
    radius = 0.10 + 0.11 * np.sin(height * 3.1 + 0.4) ** 2 * (1.1 - height / 1.6) + 0.03 * np.cos(height * 9)
    body = lathe(np.stack([np.maximum(radius, 0.02), height], axis=1), (0, 0, 0), sides=28)
    head = cushion((0.02, 1.60, 0.0), (0.24, 0.30, 0.26), roundness=0.9, rings=14, sides=24)
    return join([body, head])


def _stack() -> Surface:
    return join(
        [
            cushion((0.03 * k, 0.16 + 0.3 * k, 0.02 * k), (0.42 - 0.09 * k, 0.32, 0.42 - 0.09 * k), rings=12)
            for k in range(3)
        ]
    )


def _bench(pieces: Pieces) -> None:
    pieces.add(box((0.3, 0.42, -3.75), (1.5, 0.10, 0.45), cell_m=0.15, tile_m=0.4), "fabric", LINEN)
    for x in (-0.35, 0.95):
        for z in (-3.93, -3.57):
            pieces.add(box((x, 0.185, z), (0.05, 0.37, 0.05), without="-y+y", cell_m=0.2), "wood", OAK)
    pieces.add(box((-3.1, 0.42, 1.2), (0.45, 0.10, 1.6), cell_m=0.2, tile_m=0.4), "fabric", LINEN)
    for z in (0.5, 1.9):
        pieces.add(box((-3.1, 0.185, z), (0.35, 0.37, 0.05), without="-y+y", cell_m=0.2), "wood", OAK)


def _lamps(pieces: Pieces) -> None:
    for x, _, z in LAMPS:
        pieces.add(
            box((x, HIGH[1] - 0.03, z), (1.1, 0.06, 0.5), without="+y", cell_m=0.6), "speckle", WHITE, shades=False
        )
        glow = patch((x - 0.5, HIGH[1] - 0.062, z - 0.2), (1.0, 0, 0), (0, 0, 0.4), cell_m=1.0)
        pieces.add(glow, "speckle", (2.4, 2.25, 2.0), place=GLOWING, shades=False)


def _barrier(pieces: Pieces) -> None:
    """A cord on two posts before the left picture: thin things that stand on the floor."""
    posts = [np.array([-3.0, 0.0, -4.7]), np.array([-1.4, 0.0, -4.7])]
    profile = [(0.13, 0), (0.13, 0.02), (0.02, 0.04), (0.018, 0.9), (0.03, 0.93), (0.001, 0.96)]
    for foot in posts:
        pieces.add(lathe(profile, foot, sides=16), "speckle", GOLD)
    t = np.linspace(0, 1, 17)[:, None]
    cord = posts[0] * (1 - t) + posts[1] * t + (0, 0.88, 0) - np.array([0, 0.9, 0]) * t * (1 - t)
    pieces.add(tube(cord, 0.016, sides=8), "fabric", (0.5, 0.05, 0.06))
