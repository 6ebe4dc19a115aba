"""The seat of a small aircraft that stands on a deck, and a HUD that is fixed to the head."""

from __future__ import annotations

import numpy as np

from ...geometry import Pose
from .._content import Material
from .._model import Mesh, Scene, SceneSource, Texture, scenes
from ..effects import SceneEffect
from . import _sheets
from ._paint import Image, fractal, tinted, to_image
from ._pieces import Pieces, merged
from ._print import lettering, stamp
from ._surfaces import box, cushion, join, patch, tube
from ._yard import SKY_BACKGROUND, build_store, build_yard, yard_lights, yard_textures

SUMMARY = "a cockpit with a view and a head-up display fixed to the head: overlay"
SEED = 80
EFFECTS = SceneEffect.OVERLAY
BLACK, GREY = (0.07, 0.07, 0.08), (0.32, 0.34, 0.36)
HUD_M, HUD_AWAY_M = (0.84, 0.66), 1.0


def build() -> Scene:
    """The cockpit; the same to the last bit every time."""
    rng = np.random.default_rng(SEED)
    pieces = Pieces()
    build_yard(pieces, rng)
    build_store(pieces, rng)
    _dashboard(pieces)
    _shell(pieces)
    textures = [*yard_textures(), Texture("dials", dials()), Texture("hud", _sheets.head_up(), repeat=False)]
    index = {texture.name: i for i, texture in enumerate(textures)}
    meshes = [*merged(pieces, yard_lights(pieces, SEED + 1), index.__getitem__), _hud(index["hud"])]
    walk = ((-0.35, 0.9, -0.3), (0.35, 1.8, 0.5))
    return Scene(
        "cockpit", SUMMARY, meshes, textures, SKY_BACKGROUND, viewpoint=Pose((0.0, 1.4, 0.0)), walk_bounds_m=walk
    )


def _hud(texture: int) -> Mesh:
    """Straight ahead of the head, wherever it looks."""
    (wide, high), z = HUD_M, -HUD_AWAY_M
    surface = patch((-wide / 2, -high / 2, z), (wide, 0, 0), (0, high, 0), cell_m=1.0, uv=(0, 0, 1, 1))
    return _sheets.sheet_mesh("hud", surface, texture, (1.1, 1.1, 1.1), Material(head_locked=True))


def _dashboard(pieces: Pieces) -> None:
    """An arm's length away, with dials."""
    face = patch((-0.62, 0.72, -0.66), (1.24, 0, 0), (0, 0.36, -0.10), cell_m=0.1, uv=(0, 0, 1, 1))
    pieces.add(face, "dials")
    pieces.add(box((0, 0.70, -0.72), (1.3, 0.05, 0.2), cell_m=0.2), "speckle", BLACK)
    pieces.add(cushion((0, 1.10, -0.80), (1.34, 0.07, 0.24), roundness=0.5, tile_m=0.2), "speckle", GREY)
    pieces.add(tube([(0, 0.45, -0.30), (0.0, 0.7, -0.38), (0.02, 0.86, -0.36)], 0.014), "speckle", BLACK)
    pieces.add(cushion((0.02, 0.90, -0.36), (0.045, 0.12, 0.045), roundness=0.8), "speckle", (0.5, 0.09, 0.08))


def _shell(pieces: Pieces) -> None:
    """Sides, windscreen posts and the nose before them."""
    for side in (-1, 1):
        wall = box((side * 0.66, 0.72, -0.1), (0.06, 0.6, 1.5), cell_m=0.15, tile_m=0.6)
        pieces.add(wall, "speckle", (0.72, 0.24, 0.16))
        post = [
            (side * 0.63, 1.0, -0.82),
            (side * 0.56, 1.45, -0.62),
            (side * 0.42, 1.85, -0.25),
            (side * 0.36, 1.95, 0.3),
        ]
        pieces.add(tube(np.array(post), 0.022), "speckle", GREY)
    pieces.add(tube([(-0.42, 1.85, -0.25), (0, 1.9, -0.3), (0.42, 1.85, -0.25)], 0.018), "speckle", GREY)
    hull = cushion((0, 0.72, -1.35), (1.0, 0.62, 1.3), roundness=0.6, tile_m=0.5)
    hub = cushion((0, 0.78, -2.05), (0.3, 0.3, 0.4), roundness=0.9)
    pieces.add(join([hull, hub]), "speckle", (0.72, 0.24, 0.16))
    pieces.add(box((0, 0.78, -2.25), (1.7, 0.14, 0.03), cell_m=0.2, uv=(0, 0, 1, 0.1)), "wood", (0.7, 0.6, 0.5))


def dials(width: int = 1024, height: int = 320, seed: int = 860) -> Image:
    """Round instruments with ticks and hands, switches below, on dark enamel."""
    rng = np.random.default_rng(seed)
    image = tinted(0.5 + 0.2 * fractal(height, width, seed, 0.3), (0.10, 0.11, 0.12), (0.19, 0.20, 0.21)).copy()
    y, x = np.mgrid[:height, :width].astype(np.float32)
    for k in range(6):
        cx, cy, radius = 100 + 165 * k, 125, 68
        dx, dy = x - cx, cy - y
        far, angle = np.hypot(dx, dy), np.arctan2(dx, dy)
        image[far < radius] = (0.03, 0.03, 0.035)
        image[np.abs(far - radius) < 3] = (0.62, 0.63, 0.64)
        tick = np.abs(angle * 24 / np.pi / 2 - np.round(angle * 24 / np.pi / 2)) < 0.10
        image[tick & (far > 0.78 * radius) & (far < 0.92 * radius)] = (0.9, 0.9, 0.86)
        hand = rng.uniform(-2.4, 2.4)
        along, off = dx * np.sin(hand) + dy * np.cos(hand), dx * np.cos(hand) - dy * np.sin(hand)
        image[(along > -8) & (along < 0.72 * radius) & (np.abs(off) < 2.6)] = (0.95, 0.45, 0.15)
        stamp(
            image, lettering(("ALT", "KNOT", "FUEL", "TURN", "VOLT", "HEAD")[k], 2), cy + 22, cx - 22, (0.85, 0.85, 0.8)
        )
    for k in range(14):
        left = 60 + 66 * k
        image[245:285, left : left + 22] = (0.5, 0.5, 0.52)
        image[250 + 14 * (k % 2) : 266 + 14 * (k % 2), left + 3 : left + 19] = (
            (0.85, 0.2, 0.15) if k % 5 == 0 else (0.9, 0.9, 0.9)
        )
    return to_image(image)


scenes.register(SceneSource("cockpit", SUMMARY, build, EFFECTS))
