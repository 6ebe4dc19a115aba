"""Small and thin things: plants, cups, lamps on cords, fairy lights, and a microphone 0.4 m from the viewer's nose."""

from __future__ import annotations

import numpy as np

from ._pieces import GLOWING, Pieces
from ._room_furniture import BLACK, TABLE_CENTRE, TABLE_TOP_M
from ._surfaces import Surface, box, catenary, cushion, join, lathe, leaf, patch, tube

BRASS, STEEL, TERRACOTTA = (0.62, 0.46, 0.18), (0.34, 0.35, 0.37), (0.62, 0.27, 0.15)
PENDANT = np.array([0.75, 1.78, -2.75])
FLOOR_LAMP = np.array([-2.62, 1.62, -3.35])
DESK_LAMP = np.array([2.42, 1.18, -1.25])
CEILING_LAMP = np.array([0.0, 2.52, 1.7])


def build_things(pieces: Pieces, rng: np.random.Generator) -> None:
    """All of them."""
    _plant(pieces, rng, (-0.76, 0.0, -0.60))
    _microphone(pieces)
    _on_the_table(pieces)
    _on_the_sideboard(pieces, rng)
    _lamps(pieces)
    _fairy_lights(pieces)
    _fern(pieces, rng, (2.62, 0.0, -3.55), 56, 0.85)
    _fern(pieces, rng, (-0.12, 0.87, -4.02), 26, 0.28)
    _fern(pieces, rng, (2.55, 0.0, 2.45), 36, 0.8)


def _pot(centre: tuple, radius: float, height: float) -> Surface:
    wall = [
        (radius * 0.72, 0),
        (radius * 0.95, height * 0.8),
        (radius, height * 0.82),
        (radius, height),
        (radius * 0.9, height),
        (radius * 0.88, height * 0.85),
        (0.001, height * 0.84),
    ]
    return lathe(wall, centre, sides=20)


def _plant(pieces: Pieces, rng: np.random.Generator, place: tuple) -> None:
    """A tall plant on a stand at the viewer's left: stems and big leaves 0.4 to 0.9 m from the eyes."""
    x, _, z = place
    for angle in np.arange(3) * 2 * np.pi / 3:
        foot = np.array([x + 0.17 * np.sin(angle), 0, z + 0.17 * np.cos(angle)])
        pieces.add(
            tube(
                [
                    foot,
                    (x + 0.09 * np.sin(angle), 0.4, z + 0.09 * np.cos(angle)),
                    (x + 0.1 * np.sin(angle), 0.8, z + 0.1 * np.cos(angle)),
                ],
                0.009,
                sides=6,
            ),
            "speckle",
            BLACK,
        )
    pieces.add(_pot((x, 0.78, z), 0.14, 0.22), "speckle", TERRACOTTA)
    stems, blades = [], []
    for i in range(22):
        angle, lean = i * 2.4, rng.uniform(0.12, 0.34)
        height = rng.uniform(0.18, 0.86)
        away = np.array([np.sin(angle), 0, np.cos(angle)])
        root = np.array([x, 0.96, z]) + away * 0.03
        tip = root + away * lean * (0.5 + height) + np.array([0, height, 0])
        bend = (root + tip) / 2 + np.array([0, 0.10, 0]) - away * 0.05
        t = np.linspace(0, 1, 7)[:, None]
        stems.append(
            tube((1 - t) ** 2 * root + 2 * t * (1 - t) * bend + t**2 * tip, np.linspace(0.006, 0.003, 7), sides=5)
        )
        direction = away + np.array([0, rng.uniform(-0.1, 0.5), 0]) + rng.normal(0, 0.15, 3)
        blades.append(
            leaf(
                tip,
                direction,
                length=rng.uniform(0.17, 0.27),
                width=rng.uniform(0.09, 0.14),
                droop=rng.uniform(0.2, 0.6),
                cells=8,
            )
        )
    pieces.add(join(stems), "speckle", (0.16, 0.26, 0.09))
    for i, blade in enumerate(blades):
        pieces.add(blade, "foliage", (0.50 + 0.02 * (i % 7), 0.62 + 0.02 * (i % 5), 0.42), double_sided=True)


def _microphone(pieces: Pieces) -> None:
    """On a stand at the viewer's right, its boom reaching in; head 0.43 m from the eyes."""
    head, base = np.array([0.24, 1.46, -0.34]), np.array([0.95, 0.0, -0.62])
    pieces.add(lathe([(0.14, 0), (0.14, 0.015), (0.02, 0.03), (0.012, 0.05)], base, sides=24), "speckle", BLACK)
    top = base + (0, 1.52, 0)
    pieces.add(tube([base + (0, 0.03, 0), base + (0, 0.8, 0), top], 0.010, sides=10), "speckle", STEEL)
    pieces.add(cushion(top, (0.05, 0.05, 0.05), roundness=0.7), "speckle", BLACK)
    reach = (head + (0.05, 0.07, -0.02)) - top
    pieces.add(tube([top - reach * 0.35, top, top + reach], 0.008, sides=10), "speckle", STEEL)
    pieces.add(cushion(top - reach * 0.36, (0.07, 0.05, 0.07), roundness=0.6), "speckle", BLACK)
    body = lathe([(0.014, -0.13), (0.021, -0.12), (0.022, -0.02), (0.027, -0.01), (0.027, 0.0)], (0, 0, 0), sides=18)
    pieces.add(body.moved(head), "speckle", (0.13, 0.13, 0.14))
    angle = np.linspace(0, np.pi / 2, 9)
    grille = lathe(
        np.stack([0.027 * np.cos(angle) ** 0.6, 0.055 * np.sin(angle)], axis=1),
        (0, 0, 0),
        sides=22,
        repeats=1,
        tile_m=0.05,
    )
    pieces.add(grille.moved(head), "mesh", (0.75, 0.76, 0.78))
    pieces.add(lathe([(0.029, -0.006), (0.029, 0.006)], head, sides=22), "speckle", BRASS)
    ring = np.linspace(0, 2 * np.pi, 17)
    hoop = np.stack([0.046 * np.cos(ring), np.zeros(17), 0.046 * np.sin(ring)], axis=1)
    for y in (-0.045, -0.09):
        pieces.add(tube(hoop + head + (0, y, 0), 0.0035, sides=6), "speckle", BLACK)
    pieces.add(
        tube([head + (0.046, -0.09, 0), head + (0.052, -0.02, -0.01), head + (0.05, 0.07, -0.02)], 0.005, sides=6),
        "speckle",
        BLACK,
    )
    cable = np.concatenate(
        [
            catenary(head + (0, -0.13, 0), top - (0.1, 0.02, -0.04), 0.24, 30),
            [top - (0.02, 0.5, 0), base + (0.02, 0.05, 0)],
        ]
    )
    pieces.add(tube(cable, 0.0042, sides=6), "speckle", (0.35, 0.05, 0.05))


def _cup(place: tuple, scale: float = 1.0) -> Surface:
    profile = np.array(
        [
            (0.02, 0),
            (0.026, 0.004),
            (0.038, 0.035),
            (0.041, 0.075),
            (0.038, 0.075),
            (0.034, 0.035),
            (0.018, 0.012),
            (0.001, 0.011),
        ]
    )
    angle = np.linspace(-1.2, 1.2, 8)
    handle = tube(
        np.stack([0.030 + 0.026 * np.cos(angle), 0.04 + 0.026 * np.sin(angle), np.zeros(8)], axis=1), 0.0042, sides=6
    )
    saucer = lathe([(0.03, 0), (0.068, 0.009), (0.070, 0.012), (0.03, 0.004), (0.001, 0.004)], sides=18)
    cup = join([lathe(profile * scale, (0, 0.006, 0), sides=16), handle.moved((0, 0.006, 0)), saucer])
    return cup.moved(place, place[0] * 7)


def _on_the_table(pieces: Pieces) -> None:
    x, z = TABLE_CENTRE
    y = TABLE_TOP_M
    white, blue, red = (0.8, 0.8, 0.78), (0.16, 0.32, 0.5), (0.7, 0.3, 0.2)
    for dx, dz, tint in ((-0.55, 0.2, white), (0.25, 0.35, blue), (0.42, 0.22, white), (0.3, -0.25, red)):
        pieces.add(_cup((x + dx, y, z + dz)), "speckle", tint, double_sided=True)
    _teapot(pieces, np.array([x - 0.28, y, z - 0.02]))
    _fruit_bowl(pieces, np.array([x + 0.05, y, z - 0.02]))
    _vase(pieces, (x + 0.58, y, z - 0.12))
    pieces.add(box((x - 0.02, y + 0.004, z + 0.32), (0.32, 0.007, 0.21)), "speckle", (0.35, 0.08, 0.06))
    for left, lift in ((x - 0.02, 0.012), (x - 0.17, 0.009)):
        page = patch((left, y + lift, z + 0.42), (0.15, 0, 0), (0, 0, -0.2), cell_m=0.05, uv=(0.755, 0.1, 0.995, 0.72))
        pieces.add(page, "posters", shades=False)
    for i, tint in enumerate(((0.12, 0.2, 0.35), (0.5, 0.12, 0.08), (0.7, 0.6, 0.4))):
        book = box((0, 0, 0), (0.22, 0.028, 0.16)).moved((x - 0.58, y + 0.014 + 0.029 * i, z - 0.2), 0.3 - 0.25 * i)
        pieces.add(book, "speckle", tint)


def _teapot(pieces: Pieces, foot: np.ndarray) -> None:
    glaze = (0.10, 0.22, 0.25)
    body = [
        (0.04, 0),
        (0.075, 0.02),
        (0.085, 0.06),
        (0.07, 0.105),
        (0.035, 0.125),
        (0.03, 0.13),
        (0.012, 0.14),
        (0.014, 0.152),
        (0.001, 0.16),
    ]
    spout = tube(foot + [(0.06, 0.05, 0.02), (0.11, 0.08, 0.03), (0.13, 0.125, 0.04)], (0.016, 0.011, 0.008), sides=10)
    pieces.add(join([lathe(body, foot, sides=28), spout]), "speckle", glaze)
    angle = np.linspace(0.25, np.pi - 0.25, 14)
    handle = np.stack([0.07 * np.cos(angle), 0.1 + 0.12 * np.sin(angle), np.zeros(14)], axis=1)
    pieces.add(tube(foot + handle, 0.004, sides=6), "speckle", BRASS)


def _fruit_bowl(pieces: Pieces, foot: np.ndarray) -> None:
    bowl = [(0.05, 0), (0.06, 0.008), (0.12, 0.05), (0.155, 0.085), (0.15, 0.085), (0.11, 0.052), (0.001, 0.02)]
    pieces.add(lathe(bowl, foot, sides=32), "wood", (0.8, 0.6, 0.42), double_sided=True)
    apple, orange, pear = (0.75, 0.12, 0.06), (0.8, 0.42, 0.05), (0.42, 0.55, 0.1)
    for dx, dy, dz, radius, tint in (
        (0, 0.06, 0, 0.042, apple),
        (0.075, 0.075, 0.02, 0.04, orange),
        (-0.065, 0.075, 0.03, 0.041, pear),
        (0.01, 0.08, -0.075, 0.04, orange),
        (0.01, 0.11, 0.04, 0.039, apple),
    ):
        size = (2 * radius, 1.9 * radius, 2 * radius)
        pieces.add(cushion(foot + (dx, dy, dz), size, roundness=1.0, rings=9, sides=14), "speckle", tint)


def _vase(pieces: Pieces, place: tuple) -> None:
    rng = np.random.default_rng(7)
    x, y, z = place
    pieces.add(
        lathe(
            [(0.035, 0), (0.06, 0.05), (0.055, 0.11), (0.025, 0.17), (0.035, 0.2), (0.030, 0.2), (0.02, 0.17)],
            place,
            sides=24,
        ),
        "speckle",
        (0.75, 0.74, 0.68),
        double_sided=True,
    )
    for i in range(11):
        away = np.array([np.sin(i * 2.4), 0, np.cos(i * 2.4)]) * rng.uniform(0.04, 0.16)
        tip = np.array([x, y + rng.uniform(0.33, 0.52), z]) + away
        pieces.add(
            tube([(x, y + 0.17, z), (x + away[0] * 0.4, y + 0.28, z + away[2] * 0.4), tip], 0.0032, sides=5),
            "speckle",
            (0.16, 0.3, 0.1),
        )
        tint = ((1.3, 0.45, 0.45), (1.4, 1.1, 0.4), (1.2, 1.1, 1.25))[i % 3]
        petals = [
            leaf(tip, (np.sin(a), 0.45, np.cos(a)), length=0.042, width=0.026, droop=0.25, cells=2)
            for a in np.arange(6) * 1.047
        ]
        pieces.add(join(petals), "fabric", tint, double_sided=True, shades=False)
        pieces.add(
            cushion(tip + (0, 0.005, 0), (0.016, 0.014, 0.016), roundness=1, rings=4, sides=8),
            "speckle",
            (0.5, 0.3, 0.05),
            shades=False,
        )


def _on_the_sideboard(pieces: Pieces, rng: np.random.Generator) -> None:
    x, y, z = 2.66, 0.78, -1.75
    pieces.add(
        lathe([(0.09, 0), (0.09, 0.012), (0.015, 0.03), (0.012, 0.08)], (x, y, z - 0.55), sides=20), "speckle", BRASS
    )
    angle = np.linspace(-np.pi / 2 + 0.02, np.pi / 2, 17)
    globe = lathe(
        np.stack([0.15 * np.cos(angle), 0.24 + 0.15 * np.sin(angle)], axis=1),
        (x, y, z - 0.55),
        sides=32,
        repeats=2,
        tile_m=0.24,
    )
    pieces.add(globe, "map")
    pieces.add(box((x, y + 0.1, z - 0.08), (0.2, 0.2, 0.38), cell_m=0.1), "wood", (0.75, 0.55, 0.42))
    pieces.add(
        patch((x - 0.101, y + 0.02, z - 0.25), (0, 0, 0.2), (0, 0.16, 0), cell_m=0.1, tile_m=0.06),
        "mesh",
        (0.7, 0.62, 0.45),
    )
    for i in range(2):
        knob = lathe([(0.022, 0), (0.02, 0.02), (0.001, 0.02)], sides=14)
        turned = Surface(
            knob.positions[:, [1, 0, 2]] * (-1, 1, 1), knob.normals[:, [1, 0, 2]] * (-1, 1, 1), knob.uv, knob.triangles
        )
        pieces.add(turned.moved((x - 0.1, y + 0.06 + 0.08 * i, z + 0.05)), "speckle", BRASS)
    pieces.add(
        tube([(x, y + 0.2, z - 0.2), (x + 0.02, y + 0.45, z - 0.26), (x + 0.03, y + 0.62, z - 0.31)], 0.003, sides=5),
        "speckle",
        STEEL,
    )
    for i in range(7):
        thick, high = rng.uniform(0.02, 0.04), rng.uniform(0.18, 0.26)
        pieces.add(
            box((x, y + high / 2, z + 0.62 + 0.042 * i), (0.17, high, thick)),
            "fabric",
            tuple(rng.uniform(0.08, 0.6, 3)),
        )


def _lamps(pieces: Pieces) -> None:
    x, y, z = PENDANT
    shade = [(0.23, 0.0), (0.21, 0.06), (0.12, 0.15), (0.04, 0.19), (0.035, 0.22), (0.001, 0.225)]
    pieces.add(
        lathe(shade, PENDANT - (0, 0.04, 0), sides=36), "speckle", (0.05, 0.10, 0.09), double_sided=True, shades=False
    )
    pieces.add(tube([(x, y + 0.18, z), (x, 2.3, z), (x, 2.8, z)], 0.0045, sides=6), "speckle", BLACK, shades=False)
    pieces.add(
        cushion(PENDANT, (0.07, 0.09, 0.07), roundness=1), "speckle", (1.0, 0.82, 0.52), place=GLOWING, shades=False
    )
    pieces.add(
        cushion(CEILING_LAMP, (0.26, 0.24, 0.26), roundness=1, rings=12, sides=20),
        "speckle",
        (1.0, 0.9, 0.74),
        place=GLOWING,
        shades=False,
    )
    pieces.add(
        tube([CEILING_LAMP + (0, 0.1, 0), CEILING_LAMP + (0, 0.28, 0)], 0.008, sides=6), "speckle", BRASS, shades=False
    )
    fx, fy, fz = FLOOR_LAMP
    pieces.add(lathe([(0.15, 0), (0.15, 0.02), (0.02, 0.035)], (fx, 0, fz), sides=24), "speckle", BLACK)
    pieces.add(tube([(fx, 0.03, fz), (fx, 0.8, fz), (fx, fy + 0.1, fz)], 0.010, sides=8), "speckle", BRASS)
    pieces.add(
        lathe([(0.21, -0.13), (0.145, 0.16)], FLOOR_LAMP, sides=32, repeats=5),
        "fabric",
        (1.0, 0.74, 0.42),
        double_sided=True,
        shades=False,
        place=GLOWING,
    )
    dx, dy, dz = DESK_LAMP
    base = np.array([2.72, 0.78, dz + 0.3])
    elbow = np.array([2.78, 1.12, dz + 0.36])
    pieces.add(lathe([(0.08, 0), (0.08, 0.018), (0.012, 0.03)], base, sides=20), "speckle", (0.5, 0.07, 0.05))
    for a, b in ((base, elbow), (elbow, np.array([dx, dy + 0.06, dz]))):
        for side in (-0.012, 0.012):
            pieces.add(
                tube([a + (0, 0, side), (a + b) / 2 + (0, 0, side), b + (0, 0, side)], 0.0045, sides=6),
                "speckle",
                STEEL,
            )
    pieces.add(
        lathe([(0.085, -0.03), (0.05, 0.06), (0.02, 0.09), (0.001, 0.095)], DESK_LAMP, sides=24),
        "speckle",
        (0.5, 0.07, 0.05),
        double_sided=True,
        shades=False,
    )
    pieces.add(
        cushion(DESK_LAMP, (0.05, 0.06, 0.05), roundness=1), "speckle", (1.0, 0.9, 0.7), place=GLOWING, shades=False
    )


def _fairy_lights(pieces: Pieces) -> None:
    """Bulbs on wires from wall to wall, across the whole view."""
    spans = [((-2.98, 2.52, -3.7), (0.1, 2.6, -2.86), 0.3), ((0.1, 2.6, -2.86), (2.98, 2.5, -2.2), 0.28),
             ((-2.98, 2.45, -1.3), (0.2, 2.6, -0.94), 0.26), ((0.2, 2.6, -0.94), (2.98, 2.5, 0.4), 0.3),
             ((-2.98, 2.5, 2.0), (2.98, 2.5, 1.2), 0.35)]  # fmt: skip
    for start, end, sag in spans:
        wire = catenary(start, end, sag)
        pieces.add(tube(wire, 0.0042, sides=5), "speckle", (0.05, 0.09, 0.06), shades=False)
        for i, point in enumerate(wire[2:-2:4]):
            glow = ((1.0, 0.78, 0.42), (1.0, 0.62, 0.32), (1.0, 0.86, 0.60))[i % 3]
            pieces.add(
                cushion(point - (0, 0.035, 0), (0.036, 0.052, 0.036), roundness=1, rings=5, sides=6),
                "speckle",
                glow,
                place=GLOWING,
                shades=False,
            )
            pieces.add(lathe([(0.009, -0.018), (0.010, 0.004)], point, sides=6), "speckle", BLACK, shades=False)


def _fern(pieces: Pieces, rng: np.random.Generator, place: tuple, fronds: int, size: float) -> None:
    """A pot with arching strap leaves."""
    x, y, z = place
    height = 0.32 * size + 0.06
    pieces.add(_pot(place, 0.22 * size + 0.03, height), "speckle", (0.68, 0.66, 0.62))
    blades = []
    for i in range(fronds):
        angle = i * 2.4 + rng.normal(0, 0.2)
        direction = np.array([np.sin(angle), rng.uniform(0.5, 2.4), np.cos(angle)])
        length = size * rng.uniform(0.6, 1.1)
        root = np.array([x, y + height * 0.85, z]) + 0.05 * size * np.array([np.sin(angle), 0, np.cos(angle)])
        blades.append(
            leaf(root, direction, length=length, width=0.07 * size + 0.01, droop=rng.uniform(0.15, 0.5), cells=7)
        )
    for third in range(3):
        tint = ((0.34, 0.52, 0.26), (0.46, 0.62, 0.30), (0.28, 0.44, 0.26))[third]
        pieces.add(join(blades[third::3]), "foliage", tint, double_sided=True, shades=size > 0.5)
