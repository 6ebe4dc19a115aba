"""The room itself: floor, walls, beams, window, door. x -3..3, y 0..2.8, z -4.2..3.0; the window looks along -z."""

from __future__ import annotations

import numpy as np

from ._bake import Opening
from ._pieces import Pieces
from ._surfaces import box, patch, sheet, tube

LOW, HIGH = np.array([-3.0, 0.0, -4.2]), np.array([3.0, 2.8, 3.0])
WINDOW = Opening(-0.35, 2.25, 0.85, 2.35, -4.2)
WALL_THICKNESS_M = 0.24
# The part of the floor the sun reaches: it gets a texture of its own with rug, sun patch and shadows in it.
SUN_FLOOR = (-2.7, -3.7, 1.9, -1.1)  # x0, z0, x1, z1

DARK_WOOD = (0.55, 0.50, 0.46)
PAINT = (0.92, 0.91, 0.88)


def build_shell(pieces: Pieces) -> None:
    """Everything that does not move out with the tenant."""
    _floor(pieces)
    _walls(pieces)
    _window(pieces)
    _curtains(pieces)
    _blind(pieces)
    _door(pieces)


def _floor(pieces: Pieces) -> None:
    x0, z0, x1, z1 = SUN_FLOOR
    strips = [(-3.0, -4.2, 3.0, z0), (-3.0, z0, x0, z1), (x1, z0, 3.0, z1), (-3.0, z1, 3.0, 3.0)]
    for left, back, right, front in strips:
        uv = np.array([left, -front, right, -back]) / 2  # 2 m of boards per picture, in step over all strips
        pieces.add(
            patch((left, 0, front), (right - left, 0, 0), (0, 0, back - front), cell_m=0.2, uv=uv),
            "planks",
            shades=False,
        )
    pieces.add(
        patch((x0, 0, z1), (x1 - x0, 0, 0), (0, 0, z0 - z1), cell_m=0.13, uv=(0, 0, 1, 1)), "sun-floor", shades=False
    )


def _walls(pieces: Pieces) -> None:
    width, depth, height = 6.0, 7.2, 2.8
    pieces.add(
        patch((-3, height, -4.2), (width, 0, 0), (0, 0, depth), cell_m=0.25, tile_m=1.6), "plaster", PAINT, shades=False
    )
    pieces.add(patch((-3, 0, 3), (0, 0, -depth), (0, height, 0), cell_m=0.2), "bricks", shades=False)
    pieces.add(patch((3, 0, -4.2), (0, 0, depth), (0, height, 0), cell_m=0.2, tile_m=0.8), "wallpaper", shades=False)
    pieces.add(patch((3, 0, 3), (-width, 0, 0), (0, height, 0), cell_m=0.24, tile_m=0.8), "wallpaper", shades=False)
    w = WINDOW
    around = [
        (-3.0, 0.0, w.left_m, height),
        (w.right_m, 0.0, 3.0, height),
        (w.left_m, 0.0, w.right_m, w.bottom_m),
        (w.left_m, w.top_m, w.right_m, height),
    ]
    for left, bottom, right, top in around:
        uv = np.array([left, bottom, right, top]) / 1.6
        wall = patch((left, bottom, -4.2), (right - left, 0, 0), (0, top - bottom, 0), cell_m=0.16, uv=uv)
        pieces.add(wall, "plaster", (0.90, 0.93, 0.84), shades=False)
    for z in (-2.9, -0.9, 1.1):
        pieces.add(box((0, 2.72, z), (6.0, 0.16, 0.15), cell_m=0.2, without="+y-x+x"), "wood", DARK_WOOD, shades=False)
    for x, hidden in ((-2.985, "-x-y"), (2.985, "+x-y")):
        pieces.add(box((x, 0.05, -0.6), (0.03, 0.1, depth), without=hidden, cell_m=0.4), "speckle", PAINT, shades=False)


def _window(pieces: Pieces) -> None:
    w, deep = WINDOW, WALL_THICKNESS_M
    width, height = w.right_m - w.left_m, w.top_m - w.bottom_m
    outer = w.z_m - deep
    for corner, along, across in (
        ((w.left_m, w.bottom_m, outer), (0, 0, deep), (0, height, 0)),
        ((w.right_m, w.bottom_m, w.z_m), (0, 0, -deep), (0, height, 0)),
        ((w.left_m, w.top_m, outer), (width, 0, 0), (0, 0, deep)),
    ):
        side = patch(corner, along, across, cell_m=0.12, tile_m=1.6)
        turned = (
            side if side.normals[0] @ _to_middle(corner) > 0 else patch(corner, across, along, cell_m=0.12, tile_m=1.6)
        )
        pieces.add(turned, "plaster", PAINT, shades=False)
    pieces.add(
        box((w.left_m + width / 2, w.bottom_m - 0.02, w.z_m + 0.02), (width + 0.2, 0.04, 0.56), cell_m=0.12),
        "wood",
        (1.1, 1.05, 1.0),
    )
    bars = [
        (x, w.bottom_m + height / 2, 0.055, height) for x in (w.left_m + 0.03, w.right_m - 0.03, w.left_m + width / 2)
    ]
    bars += [(w.left_m + width / 2, y, width, 0.055) for y in (w.bottom_m + 0.03, w.top_m - 0.03)]
    bars += [(w.left_m + width * share, w.bottom_m + height / 2, 0.026, height) for share in (0.25, 0.75)]
    bars += [(w.left_m + width / 2, w.bottom_m + height * share, width, 0.026) for share in (0.36, 0.70)]
    for x, y, wide, high in bars:
        deep_bar = 0.06 if max(wide, high) > 0 and min(wide, high) > 0.03 else 0.035
        pieces.add(box((x, y, w.z_m - 0.12), (wide, high, deep_bar), cell_m=0.2), "speckle", PAINT)


def _to_middle(corner: tuple[float, float, float]) -> np.ndarray:
    w = WINDOW
    middle = np.array([(w.left_m + w.right_m) / 2, (w.bottom_m + w.top_m) / 2, w.z_m - WALL_THICKNESS_M / 2])
    return middle - np.array(corner)


def _curtains(pieces: Pieces) -> None:
    pieces.add(tube([(-1.0, 2.5, -4.08), (0.9, 2.5, -4.08), (2.9, 2.5, -4.08)], 0.014), "wood", (0.5, 0.45, 0.42))
    for left, right, phase in ((-0.92, -0.28, 0.0), (2.18, 2.82, 1.7)):
        u, v = np.linspace(0, 1, 57), np.linspace(1, 0, 9)
        vv, uu = np.meshgrid(v, u, indexing="ij")
        fold = 0.045 * np.sin(uu * 2 * np.pi * 7 + phase) * (0.7 + 0.3 * (1 - vv))
        x = left + uu * (right - left) + 0.03 * np.sin(vv * 5 + phase) * (1 - vv)
        points = np.stack([x, 0.06 + 2.42 * vv, -4.08 + fold], axis=-1)
        uv = np.stack([uu * 5, vv * 9.6], axis=-1)
        pieces.add(sheet(points, uv), "fabric", (0.72, 0.46, 0.16), double_sided=True)


def _blind(pieces: Pieces) -> None:
    """A venetian blind half down before the right panes."""
    left, right = 1.02, 2.19
    for y in np.arange(1.62, 2.29, 0.032):
        slat = patch((left, y - 0.008, -4.145), (right - left, 0, 0), (0, 0.016, -0.028), cell_m=0.3, tile_m=0.5)
        pieces.add(slat, "speckle", (0.86, 0.80, 0.68), double_sided=True)
    pieces.add(box(((left + right) / 2, 2.31, -4.155), (right - left, 0.04, 0.05)), "speckle", (0.8, 0.75, 0.65))
    pieces.add(box(((left + right) / 2, 1.595, -4.155), (right - left, 0.025, 0.035)), "speckle", (0.8, 0.75, 0.65))
    for x in (left + 0.15, right - 0.15, right - 0.03):
        low = 1.05 if x > right - 0.1 else 1.6
        pieces.add(
            tube([(x, 2.3, -4.13), (x, (2.3 + low) / 2, -4.13), (x, low, -4.13)], 0.0035, sides=5),
            "speckle",
            (0.9, 0.88, 0.8),
        )


def _door(pieces: Pieces) -> None:
    pieces.add(box((-1.2, 1.03, 2.985), (0.92, 2.06, 0.05), without="+z-y"), "wood", (0.95, 0.9, 0.85))
    for y, high in ((0.55, 0.7), (1.5, 0.8)):
        for x in (-1.4, -1.0):
            pieces.add(box((x, y, 2.955), (0.3, high, 0.02), without="+z"), "wood", (0.8, 0.75, 0.7))
    for x in (-1.70, -0.70):
        pieces.add(box((x, 1.05, 2.97), (0.08, 2.1, 0.07), without="+z-y"), "speckle", PAINT)
    pieces.add(box((-1.2, 2.13, 2.97), (1.08, 0.08, 0.07), without="+z"), "speckle", PAINT)
    pieces.add(
        tube([(-0.82, 1.0, 2.97), (-0.82, 1.0, 2.90), (-0.86, 1.0, 2.89), (-0.95, 1.0, 2.89)], 0.011),
        "speckle",
        (0.8, 0.68, 0.4),
    )
