"""What a tenant brings: table, chairs, sofa, shelves, sideboard, pictures. Nothing of size stands where a head may walk."""

from __future__ import annotations

import numpy as np

from ._pieces import Pieces
from ._print import SPINES
from ._surfaces import Surface, box, cushion, join, lathe, patch, tube

OAK, WALNUT, BLACK = (1.15, 1.0, 0.85), (0.62, 0.52, 0.45), (0.06, 0.06, 0.065)
TABLE_TOP_M, TABLE_CENTRE = 0.75, (0.75, -2.75)


def build_furniture(pieces: Pieces, rng: np.random.Generator) -> None:
    """All furniture."""
    _table(pieces)
    for (x, z), turn in (
        ((0.30, -2.12), 0.25),
        ((1.28, -2.18), -0.3),
        ((0.45, -3.38), np.pi + 0.15),
        ((1.15, -3.36), np.pi - 0.2),
    ):
        _chair(pieces, (x, 0, z), turn)
    _sofa(pieces)
    _shelf(pieces, rng, (-2.05, 0, -4.02), size=(1.7, 2.25), boards=6, turn=0.0)
    _shelf(pieces, rng, (1.3, 0, 2.82), size=(2.2, 2.0), boards=5, turn=np.pi)
    _sideboard(pieces)
    _pictures(pieces)
    _radiator(pieces)
    _armchair(pieces)


def _table(pieces: Pieces) -> None:
    x, z = TABLE_CENTRE
    pieces.add(box((x, TABLE_TOP_M - 0.0175, z), (1.6, 0.035, 0.9), cell_m=0.05, tile_m=0.9), "wood", OAK)
    for dx, dz in ((-0.7, -0.36), (0.7, -0.36), (-0.7, 0.36), (0.7, 0.36)):
        leg = tube(
            [
                (x + dx * 0.97, TABLE_TOP_M - 0.03, z + dz * 0.97),
                (x + dx, 0.35, z + dz),
                (x + dx * 1.03, 0, z + dz * 1.03),
            ],
            (0.030, 0.024, 0.016),
        )
        pieces.add(leg, "wood", OAK)
    for dz in (-0.36, 0.36):
        pieces.add(box((x, TABLE_TOP_M - 0.07, z + dz), (1.36, 0.07, 0.02)), "wood", OAK)
    for dx in (-0.68, 0.68):
        pieces.add(box((x + dx, TABLE_TOP_M - 0.07, z), (0.02, 0.07, 0.7)), "wood", OAK)


def _chair(pieces: Pieces, place: tuple[float, float, float], turn: float) -> None:
    """A spindle-back chair: thin legs, rungs and rods; its sitter looks along -z before `turn`."""
    wood: list[Surface] = [cushion((0, 0.45, 0), (0.44, 0.035, 0.42), roundness=0.3, rings=4, sides=20)]
    feet = {
        (sx, sz): (np.array([0.16 * sx, 0.44, 0.15 * sz]), np.array([0.21 * sx, 0, 0.20 * sz]))
        for sx in (-1, 1)
        for sz in (-1, 1)
    }
    for top, bottom in feet.values():
        wood.append(
            tube([top, (top * 2 + bottom) / 3, (top + 2 * bottom) / 3, bottom], (0.013, 0.016, 0.015, 0.010), sides=7)
        )
    for (ax, az), (bx, bz), share in (((-1, -1), (-1, 1), 0.55), ((1, -1), (1, 1), 0.55), ((-1, 0), (1, 0), 0.55)):
        ends = [_along(feet, sx, sz, share) for sx, sz in ((ax, az), (bx, bz))]
        wood.append(tube([ends[0], (ends[0] + ends[1]) / 2, ends[1]], (0.008, 0.011, 0.008), sides=6))
    for x in np.linspace(-0.17, 0.17, 7):
        thick = 0.012 if abs(x) > 0.16 else 0.007
        wood.append(tube([(x, 0.45, 0.18), (x * 1.08, 0.68, 0.215), (x * 1.16, 0.92, 0.26)], thick, sides=6))
    angle = np.linspace(-1, 1, 9)
    rail = np.stack([0.215 * angle, 0.93 - 0.02 * angle**2, 0.265 - 0.03 * angle**2 + 0.01], axis=1)
    wood.append(tube(rail, 0.017, sides=8))
    pieces.add(join(wood).moved(place, turn), "wood", WALNUT)


def _along(feet: dict, sx: int, sz: int, share: float) -> np.ndarray:
    if sz == 0:
        return (_along(feet, sx, -1, share) + _along(feet, sx, 1, share)) / 2
    top, bottom = feet[sx, sz]
    return top * (1 - share) + bottom * share


def _sofa(pieces: Pieces) -> None:
    """Along the brick wall; the sitter looks along +x."""
    body, soft, pillow = (
        (0.10, 0.20, 0.24),
        (0.13, 0.25, 0.29),
        [(0.75, 0.30, 0.14), (0.82, 0.72, 0.55), (0.30, 0.42, 0.24)],
    )
    z0, z1 = -2.85, -0.95
    middle, long = (z0 + z1) / 2, z1 - z0
    pieces.add(box((-2.5, 0.24, middle), (0.86, 0.2, long), tile_m=0.3, cell_m=0.2), "fabric", body)
    pieces.add(cushion((-2.82, 0.58, middle), (0.26, 0.62, long), roundness=0.22, rings=10, sides=24), "fabric", body)
    for z in (z0 - 0.06, z1 + 0.06):
        pieces.add(cushion((-2.5, 0.42, z), (0.88, 0.52, 0.2), roundness=0.25, rings=10, sides=20), "fabric", body)
    for i in range(2):
        z = z0 + long * (i + 0.5) / 2
        pieces.add(
            cushion((-2.42, 0.42, z), (0.76, 0.2, long / 2 - 0.01), roundness=0.22, rings=10, sides=24), "fabric", soft
        )
        pieces.add(
            cushion((-2.62, 0.66, z), (0.22, 0.46, long / 2 - 0.03), roundness=0.3, rings=10, sides=20), "fabric", soft
        )
    for (x, z, turn), tint in zip(((-2.45, -2.55, 0.5), (-2.42, -1.2, -0.35), (-2.47, -1.5, 0.1)), pillow, strict=True):
        pieces.add(
            cushion((0, 0, 0), (0.16, 0.42, 0.42), roundness=0.55, rings=10, sides=20).moved((x, 0.70, z), turn),
            "fabric",
            tint,
        )
    for x in (-2.85, -2.15):
        for z in (z0 + 0.08, z1 - 0.08):
            pieces.add(tube([(x, 0.15, z), (x, 0.07, z), (x, 0, z)], (0.022, 0.018, 0.013)), "wood", WALNUT)


def _shelf(
    pieces: Pieces, rng: np.random.Generator, place: tuple, *, size: tuple[float, float], boards: int, turn: float
) -> None:
    """Boards between two sides, filled with books standing, leaning and lying, and a few pots; open towards +z before `turn`."""
    (width, height), deep = size, 0.3
    frame = [box((sx * width / 2, height / 2, 0), (0.025, height, deep), cell_m=0.16, tile_m=0.9) for sx in (-1, 1)]
    levels = np.linspace(0.06, height - 0.02, boards)
    frame += [box((0, y, 0), (width, 0.022, deep), cell_m=0.12, tile_m=0.9) for y in levels]
    frame.append(patch((-width / 2, 0, -deep / 2 + 0.01), (width, 0, 0), (0, height, 0), cell_m=0.16, tile_m=0.9))
    pieces.add(join(frame).moved(place, turn), "wood", OAK)
    room_m = levels[1] - levels[0]
    for y in levels[:-1]:
        spines, pages, pots = _row_of_books(rng, width, room_m, y + 0.011)
        pieces.add(join(spines).moved(place, turn), "books")
        pieces.add(join(pages).moved(place, turn), "speckle", (0.85, 0.8, 0.68), shades=False)
        for pot in pots:
            pieces.add(pot.moved(place, turn), "speckle", tuple(rng.uniform(0.15, 0.8, 3)), double_sided=True)


def _row_of_books(
    rng: np.random.Generator, width: float, room_m: float, y: float
) -> tuple[list[Surface], list[Surface], list[Surface]]:
    """Spines with their covers, page blocks seen from above, and pots between them, from left to right on a board at height y."""
    x, end = -width / 2 + 0.03, width / 2 - 0.03
    spines, pages, pots = [], [], []
    while x < end - 0.06:
        if rng.random() < 0.07:
            pots.append(
                lathe(
                    [(0.03, 0), (0.055, 0.02), (0.06, 0.09), (0.035, 0.14), (0.03, 0.17)], (x + 0.07, y, 0.03), sides=14
                )
            )
            x += 0.15
            continue
        thick, high, deep = rng.uniform(0.018, 0.05), rng.uniform(0.6, 0.93) * (room_m - 0.03), rng.uniform(0.16, 0.23)
        u = int(rng.integers(SPINES)) / SPINES
        front = 0.14 - rng.uniform(0.0, 0.03)
        cover = (u + 0.1 / SPINES, 0.35, u + 0.2 / SPINES, 0.4)
        spines.append(patch((x, y, front), (thick, 0, 0), (0, high, 0), cell_m=0.16, uv=(u, 0, u + 1 / SPINES, 1)))
        spines.append(patch((x, y, front - deep), (0, 0, deep), (0, high, 0), cell_m=0.3, uv=cover))
        spines.append(patch((x + thick, y, front), (0, 0, -deep), (0, high, 0), cell_m=0.3, uv=cover))
        pages.append(
            patch((x + 0.002, y + high - 0.003, front - 0.003), (thick - 0.004, 0, 0), (0, 0, -deep), cell_m=0.3)
        )
        x += thick + (rng.uniform(0.0, 0.004) if rng.random() < 0.93 else rng.uniform(0.03, 0.09))
    return spines, pages, pots


def _sideboard(pieces: Pieces) -> None:
    """A low cupboard along the wallpaper, with drawers and a record player's worth of things on it."""
    x, z, long, high, deep = 2.66, -1.75, 1.9, 0.78, 0.5
    pieces.add(box((x, high / 2 + 0.08, z), (deep, high - 0.16, long), cell_m=0.1, tile_m=0.9), "wood", OAK)
    front = x - deep / 2
    for i in range(3):
        for y, tall in ((0.64, 0.18), (0.34, 0.36)):
            part = z - long / 2 + long * (i + 0.5) / 3
            pieces.add(
                box((front - 0.008, y, part), (0.016, tall, long / 3 - 0.02), without="+x", cell_m=0.16, tile_m=0.7),
                "wood",
                (1.3, 1.1, 0.9),
            )
            pieces.add(
                cushion((front - 0.03, y, part), (0.03, 0.03, 0.03), roundness=1.0, rings=5, sides=8),
                "speckle",
                (0.6, 0.48, 0.2),
            )
    for dz in (-0.85, 0.85):
        for dx in (-0.2, 0.2):
            pieces.add(
                tube(
                    [(x + dx, 0.18, z + dz), (x + dx * 1.03, 0.09, z + dz), (x + dx * 1.06, 0, z + dz)],
                    (0.02, 0.017, 0.012),
                ),
                "wood",
                OAK,
            )


def _pictures(pieces: Pieces) -> None:
    """Framed prints on brick, wallpaper and beside the door."""
    left, right, behind = (0, 0, -1.0), (0, 0, 1.0), (-1.0, 0, 0)
    prints = [
        ((-2.985, 1.58, -2.45), left, 0.56, 0), ((-2.985, 1.62, -1.75), left, 0.50, 1), ((-2.985, 1.55, -1.05), left, 0.56, 2),
        ((-2.985, 1.55, 0.6), left, 0.7, 3), ((-2.985, 1.6, 1.7), left, 0.56, 1),
        ((2.985, 1.70, -2.75), right, 0.48, 1), ((2.985, 1.62, -2.0), right, 0.62, 3), ((2.985, 1.68, -1.2), right, 0.5, 0),
        ((2.985, 1.6, 0.4), right, 0.6, 2), ((2.985, 1.6, 1.5), right, 0.5, 0), ((-2.3, 1.55, 2.985), behind, 0.5, 2),
    ]  # fmt: skip
    for centre, across, width, index in prints:
        _framed(pieces, np.array(centre), np.array(across), width, index)


def _framed(pieces: Pieces, centre: np.ndarray, across: np.ndarray, width: float, index: int) -> None:
    height, up = width * 1.5, np.array([0, 1.0, 0])
    out = np.cross(across, up)
    corner = centre - across * width / 2 - up * height / 2 + out * 0.012
    uv = (index / 4 + 0.002, 0.004, (index + 1) / 4 - 0.002, 0.996)
    pieces.add(patch(corner, across * width, up * height, cell_m=0.16, uv=uv), "posters", shades=False)
    for side in (-1, 1):
        for a, b, la, lb in ((across, up, 0.03, height + 0.06), (up, across, 0.03, width)):
            half = (width if a is across else height) / 2 + 0.015
            size = np.abs(a) * la + np.abs(b) * lb + np.abs(out) * 0.035
            pieces.add(
                box(centre + a * side * half + out * 0.012, size, cell_m=0.3, tile_m=0.6),
                "wood",
                BLACK if index % 2 else WALNUT,
                shades=False,
            )


def _radiator(pieces: Pieces) -> None:
    ribs = [
        cushion((x, 0.40, -4.10), (0.05, 0.56, 0.10), roundness=0.5, rings=6, sides=8)
        for x in np.arange(-0.05, 1.96, 0.072)
    ]
    ribs.append(tube([(-0.1, 0.16, -4.1), (1.0, 0.16, -4.1), (2.0, 0.16, -4.1)], 0.014))
    pieces.add(join(ribs), "speckle", (0.80, 0.79, 0.75))


def _armchair(pieces: Pieces) -> None:
    tint, place, turn = (0.42, 0.18, 0.10), (-2.3, 0, 2.25), 2.4
    parts = [
        cushion((0, 0.36, 0), (0.66, 0.24, 0.62), roundness=0.3), cushion((0, 0.68, 0.28), (0.68, 0.66, 0.2), roundness=0.35),
        cushion((-0.36, 0.45, 0), (0.14, 0.4, 0.66), roundness=0.35), cushion((0.36, 0.45, 0), (0.14, 0.4, 0.66), roundness=0.35),
    ]  # fmt: skip
    pieces.add(join(parts).moved(place, turn), "fabric", tint)
    legs = [
        tube([(sx * 0.28, 0.26, sz * 0.24), (sx * 0.3, 0.12, sz * 0.26), (sx * 0.32, 0, sz * 0.28)], 0.015)
        for sx in (-1, 1)
        for sz in (-1, 1)
    ]
    pieces.add(join(legs).moved(place, turn), "wood", WALNUT)
