"""A small greenhouse on a deck: dusty, lettered and coloured panes in front of everything, and a picket fence of alpha outside."""

from __future__ import annotations

import numpy as np

from ...geometry import Pose
from .._content import Material
from .._model import Mesh, Scene, SceneSource, Texture, scenes
from ..effects import SceneEffect
from . import _sheets
from ._pieces import Pieces, merged
from ._room_things import _plant, _pot
from ._surfaces import box, join, leaf, patch, tube
from ._yard import SKY_BACKGROUND, build_store, build_yard, yard_lights, yard_textures

SUMMARY = "a greenhouse with dusty, lettered and coloured panes, and a picket fence of alpha outside: transparency"
SEED = 60
EFFECTS = SceneEffect.TRANSPARENCY
PAINT = (0.80, 0.84, 0.80)
HALF_WIDE, FRONT, BACK = 1.7, -1.55, 1.6  # metres from the middle
SILL, HEAD, RIDGE = 0.7, 2.05, 2.75
BAYS = 3  # panes side by side in the front
CELL_M = 0.3  # sheets are sorted by triangle: small ones come in the right order
DAY = (0.78, 0.80, 0.80)
GREEN, AMBER, BLUE = (0.62, 0.92, 0.72), (1.0, 0.80, 0.45), (0.55, 0.75, 1.0)


def build() -> Scene:
    """The greenhouse; the same to the last bit every time."""
    rng = np.random.default_rng(SEED)
    pieces = Pieces()
    build_yard(pieces, rng)
    build_store(pieces, rng)
    _frame(pieces)
    _plants(pieces, rng)
    textures = [*yard_textures(), *_sheet_textures()]
    index = {texture.name: i for i, texture in enumerate(textures)}
    meshes = [*merged(pieces, yard_lights(pieces, SEED + 1), index.__getitem__), *_panes(index), _fence(index)]
    walk = ((-0.8, 0.8, -0.8), (0.8, 2.0, 0.9))
    return Scene(
        "greenhouse", SUMMARY, meshes, textures, SKY_BACKGROUND, viewpoint=Pose((0.0, 1.5, 0.0)), walk_bounds_m=walk
    )


def _sheet_textures() -> list[Texture]:
    pictures = {
        "pane": _sheets.dusty_glass(("WARP", "AND", "FIELD")),
        "pane-plain": _sheets.dusty_glass((), seed=810),
        "leaded": _sheets.leaded_glass(),
        "pickets": _sheets.pickets(),
    }
    return [Texture(name, image) for name, image in pictures.items()]


def _frame(pieces: Pieces) -> None:
    """Low walls, posts and rafters; the glass lies between."""
    wide, deep = 2 * HALF_WIDE, BACK - FRONT
    middle = (FRONT + BACK) / 2
    for x in (-HALF_WIDE, HALF_WIDE):
        pieces.add(box((x, SILL / 2, middle), (0.10, SILL, deep), cell_m=0.2, without="-y"), "bricks")
        for y in (SILL, HEAD):
            pieces.add(box((x, y, middle), (0.07, 0.05, deep), cell_m=0.3), "speckle", PAINT)
    pieces.add(box((0, SILL / 2, FRONT), (wide, SILL, 0.10), cell_m=0.2, without="-y"), "bricks")
    for y in (SILL, HEAD, 1.72):
        pieces.add(box((0, y, FRONT), (wide, 0.04, 0.05), cell_m=0.3), "speckle", PAINT)
    for x in np.linspace(-HALF_WIDE, HALF_WIDE, BAYS + 1):
        pieces.add(box((x, (SILL + HEAD) / 2, FRONT), (0.045, HEAD - SILL, 0.05), cell_m=0.3), "speckle", PAINT)
        pieces.add(
            tube([(x, HEAD, FRONT), (x, (HEAD + RIDGE) / 2, middle / 2 + FRONT / 2), (x, RIDGE, middle)], 0.022),
            "speckle",
            PAINT,
        )
    for z in np.linspace(FRONT, BACK, 4)[1:]:
        for x in (-HALF_WIDE, HALF_WIDE):
            pieces.add(box((x, (SILL + HEAD) / 2, z), (0.045, HEAD - SILL, 0.045), cell_m=0.3), "speckle", PAINT)
    pieces.add(
        tube([(-HALF_WIDE, RIDGE, middle), (0, RIDGE, middle), (HALF_WIDE, RIDGE, middle)], 0.03), "speckle", PAINT
    )


def _plants(pieces: Pieces, rng: np.random.Generator) -> None:
    """One tall one beside the viewer, pots on a bench along the front: they stand before the glass."""
    _plant(pieces, rng, (-0.95, 0.0, -0.75))
    pieces.add(box((0.45, 0.74, FRONT + 0.3), (2.2, 0.04, 0.42), cell_m=0.15), "wood", (0.8, 0.75, 0.7))
    for k, x in enumerate((-0.4, 0.15, 0.7, 1.2)):
        foot = np.array([x, 0.76, FRONT + 0.3])
        pieces.add(_pot(tuple(foot), 0.09, 0.14), "speckle", (0.62, 0.30, 0.19))
        blades = []
        for i in range(12):
            angle, high = 2.4 * i + k, rng.uniform(0.05, 0.25)
            way = np.array([np.sin(angle), rng.uniform(0.8, 2.0), np.cos(angle)])
            blades.append(leaf(foot + (0, 0.12, 0), way, length=0.14 + high, width=rng.uniform(0.03, 0.06), droop=0.35))
        pieces.add(join(blades), "foliage", (0.45, 0.66 + 0.05 * k, 0.38), double_sided=True)


def _panes(index: dict[str, int]) -> list[Mesh]:
    """Lettered glass in the front, coloured lights above it, leaded glass at the sides, plain glass in the roof."""
    edges, meshes = np.linspace(-HALF_WIDE, HALF_WIDE, BAYS + 1), []

    def add(name: str, corner, edge_u, edge_v, texture: str, **material: object) -> None:
        surface = patch(corner, edge_u, edge_v, cell_m=CELL_M, uv=(0, 0, 1, 1))
        made = Material(see_through=True, **material)
        meshes.append(_sheets.sheet_mesh(name, surface, index[texture], DAY, made))

    middle, wide = (FRONT + BACK) / 2, 2 * HALF_WIDE / BAYS
    for bay, left in enumerate(edges[:-1]):
        texture = "pane" if bay == 1 else "pane-plain"
        add(f"front-{bay}", (left, SILL, FRONT), (wide, 0, 0), (0, 1.72 - SILL, 0), texture)
        tint = (AMBER, GREEN, BLUE)[bay]
        add(f"light-{bay}", (left, 1.72, FRONT), (wide, 0, 0), (0, HEAD - 1.72, 0), "pane-plain", tint=tint)
        add(
            f"roof-{bay}",
            (left, HEAD, FRONT),
            (wide, 0, 0),
            (0, RIDGE - HEAD, middle - FRONT),
            "pane-plain",
            opacity=0.8,
        )
    for side in (-1, 1):
        for k, z in enumerate(np.linspace(FRONT, BACK, 4)[:-1]):
            deep = (BACK - FRONT) / 3
            start, along = (z, deep) if side > 0 else (z + deep, -deep)
            corner = (side * HALF_WIDE, SILL, start)
            add(
                f"side-{side}-{k}",
                corner,
                (0, 0, along),
                (0, HEAD - SILL, 0),
                "leaded",
                tint=GREEN if k == 0 else (1.0, 1.0, 1.0),
            )
    return meshes


def _fence(index: dict[str, int]) -> Mesh:
    """Across the deck behind the front glass."""
    surface = patch((-3.6, 0.0, -3.3), (7.2, 0, 0), (0, 1.15, 0), cell_m=CELL_M, uv=(0, 0.01, 18, 0.99))
    return _sheets.sheet_mesh("fence", surface, index["pickets"], (0.85, 0.80, 0.72), Material(see_through=True))


scenes.register(SceneSource("greenhouse", SUMMARY, build, EFFECTS))
