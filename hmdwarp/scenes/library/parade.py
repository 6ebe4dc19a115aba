"""A flag in the wind and a person who marches on the spot and waves: things that deform, on a deck with a view."""

from __future__ import annotations

import numpy as np

from ...geometry import Pose
from .._model import Mesh, Scene, SceneSource, Texture, scenes
from ..deformations import Waving
from ..effects import SceneEffect
from ._paint import Image, fractal, to_image
from ._parade_figure import figure_meshes
from ._pieces import Piece, Pieces, merged
from ._surfaces import cushion, lathe, sheet, tube
from ._yard import SKY_BACKGROUND, STEEL, body_lights, build_store, build_yard, yard_lights, yard_textures

SUMMARY = "a walled deck with a waving flag and a marching figure that waves: soft motion by itself"
SEED = 60
POLE = (-1.25, -2.5)  # x, z
FLAG_TOP_M, FLAG_SIZE_M = 2.5, (1.3, 0.85)
DOWNWIND = np.array(
    [np.cos(0.9), 0.0, -np.sin(0.9)]
)  # away from the viewer at an angle, so that its swing is seen from the side
FIGURE = (0.55, 0.0, -2.3)


def build() -> Scene:
    """The parade; the same to the last bit every time."""
    rng = np.random.default_rng(SEED)
    pieces = Pieces()
    build_yard(pieces, rng)
    build_store(pieces, rng)
    x, z = POLE
    pieces.add(tube([(x, 0, z), (x, 1.4, z), (x, FLAG_TOP_M + 0.12, z)], 0.022, sides=12), "speckle", STEEL)
    pieces.add(lathe([(0.3, 0), (0.3, 0.05), (0.06, 0.09), (0.04, 0.2)], (x, 0, z), sides=24), "speckle", STEEL)
    pieces.add(cushion((x, FLAG_TOP_M + 0.15, z), (0.09, 0.09, 0.09), roundness=1), "speckle", (0.9, 0.7, 0.25))
    textures = [*yard_textures(), Texture("flag", _flag_picture(), repeat=False)]
    index = {texture.name: i for i, texture in enumerate(textures)}
    still = merged(pieces, yard_lights(pieces, SEED + 1), index.__getitem__)
    meshes = [*still, _flag(index["flag"]), *figure_meshes(FIGURE, index.__getitem__)]
    walk = ((-1.0, 0.8, -1.0), (1.2, 2.2, 1.6))
    return Scene(
        "parade", SUMMARY, meshes, textures, SKY_BACKGROUND, viewpoint=Pose((0.0, 1.6, 0.0)), walk_bounds_m=walk
    )


def _flag(texture: int) -> Mesh:
    """Held at the pole; it swings to and fro across the wind, lower rows a little behind."""
    across, down = np.linspace(0, 1, 49), np.linspace(0, 1, 25)
    dd, aa = np.meshgrid(down[::-1], across, indexing="ij")
    wide, high = FLAG_SIZE_M
    away = aa * wide
    foot = np.array([POLE[0], FLAG_TOP_M - high, POLE[1]])
    points = foot + (0.02 + away)[..., None] * DOWNWIND + (dd * high - 0.10 * away)[..., None] * (0.0, 1.0, 0.0)
    cloth = sheet(points, np.stack([aa, dd], axis=-1))
    piece = Piece(cloth, "flag", double_sided=True)
    lag = (0.15 * (1 - dd)).reshape(-1)
    swings = np.cross(DOWNWIND, (0, 1, 0)) + (0, 0.2, 0)
    motion = Waving(cloth.positions, away.reshape(-1), swings, height_m=0.2, length_m=1.1, period_s=2.2, lag=lag)
    light = body_lights([piece])[0]
    return Mesh(
        "flag",
        cloth.positions,
        cloth.normals,
        cloth.uv,
        light,
        cloth.triangles,
        texture,
        double_sided=True,
        deformation=motion,
    )


def _flag_picture(height: int = 256, width: int = 384) -> Image:
    """Stripes, a ring of dots and the weave of the cloth."""
    y, x = np.meshgrid(np.arange(height) / height, np.arange(width) / width, indexing="ij")
    stripe = (y * 5).astype(int) % 2
    image = np.where(stripe[..., None] == 0, (0.78, 0.16, 0.14), (0.95, 0.92, 0.84))
    u, v = (x - 0.3) * width / height, y - 0.5
    disc = np.hypot(u, v) < 0.34
    image = np.where(disc[..., None], (0.14, 0.24, 0.46), image)
    for angle in np.arange(12) * np.pi / 6:
        dot = np.hypot(u - 0.25 * np.cos(angle), v - 0.25 * np.sin(angle)) < 0.035
        image = np.where(dot[..., None], (0.95, 0.80, 0.30), image)
    weave = 0.03 * fractal(height, width, 900, 0.2) + 0.03 * fractal(height, width, 901, 1.2)
    return to_image(image + weave[..., None])


scenes.register(SceneSource("parade", SUMMARY, build, SceneEffect.SOFT_MOTION))
