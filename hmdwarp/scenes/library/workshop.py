"""Three things that move by themselves on a deck full of things that do not: a fan, a cart and a thrown ball."""

from __future__ import annotations

import attrs
import numpy as np

from ...geometry import Pose
from .._model import Mesh, Scene, SceneSource, scenes
from ..effects import SceneEffect
from . import _workshop_bodies as moving
from ._pieces import Pieces, merged
from ._surfaces import box, lathe, tube
from ._yard import DARK, SKY_BACKGROUND, STEEL, body_lights, build_store, build_yard, yard_lights, yard_textures

SUMMARY = "a walled deck with a turning fan, a cart on its round and a thrown ball: rigid motion by itself"
SEED = 40
EFFECTS = SceneEffect.RIGID_MOTION


def build() -> Scene:
    """The workshop; the same to the last bit every time."""
    rng = np.random.default_rng(SEED)
    pieces = Pieces()
    build_yard(pieces, rng)
    build_store(pieces, rng)
    _bench(pieces)
    _fan_stand(pieces)
    for centre in moving.BASKETS:
        for surface, texture, tint in moving.basket(centre):
            pieces.add(surface, texture, tint, double_sided=texture == "fabric")
    textures = yard_textures()
    index = {texture.name: i for i, texture in enumerate(textures)}
    still = merged(pieces, yard_lights(pieces, SEED + 1), index.__getitem__)
    meshes = [*still, *_body_meshes(index)]
    walk = ((-1.2, 0.8, -1.2), (1.2, 2.2, 1.6))
    return Scene(
        "workshop",
        SUMMARY,
        meshes,
        textures,
        SKY_BACKGROUND,
        bodies=moving.bodies(),
        viewpoint=Pose((0.0, 1.6, 0.0)),
        walk_bounds_m=walk,
    )


def _body_meshes(index: dict[str, int]) -> list[Mesh]:
    meshes = []
    for number, (name, pieces) in enumerate(
        (("fan", moving.fan()), ("cart", moving.cart()), ("ball", moving.ball())), start=1
    ):
        made = merged(pieces, body_lights(pieces), index.__getitem__)
        meshes += [attrs.evolve(mesh, name=f"{name}-{mesh.name}", body=number) for mesh in made]
    return meshes


def _bench(pieces: Pieces) -> None:
    """Along the right wall, with tools on it."""
    pieces.add(box((3.05, 0.86, -2.7), (0.8, 0.07, 1.5), cell_m=0.14, uv=(0, 0, 1, 0.6)), "wood", (0.8, 0.7, 0.6))
    for x in (2.75, 3.35):
        for z in (-3.35, -2.05):
            pieces.add(box((x, 0.41, z), (0.09, 0.82, 0.09)), "wood", (0.6, 0.52, 0.45))
    pieces.add(box((3.1, 0.98, -2.4), (0.3, 0.18, 0.16)), "speckle", (0.2, 0.36, 0.5))
    pieces.add(
        lathe([(0.07, 0), (0.075, 0.2), (0.06, 0.2), (0.055, 0.02)], (2.9, 0.895, -2.95), sides=20),
        "speckle",
        (0.7, 0.25, 0.16),
    )
    for k in range(4):
        top = (2.87 + 0.03 * k, 1.22 - 0.03 * k, -2.98 + 0.02 * k)
        pieces.add(tube([(2.9, 0.93, -2.95), (2.9, 1.05, -2.96), top], 0.008, sides=6), "wood", (1.0, 0.8, 0.5))


def _fan_stand(pieces: Pieces) -> None:
    """Foot, pole and motor behind the blades; what stands before them would hide the test."""
    x, y, z = moving.FAN
    foot = [(0.24, 0), (0.24, 0.02), (0.05, 0.05), (0.022, 0.12), (0.02, y - 0.06)]
    pieces.add(lathe(foot, (x, 0, z - 0.12), sides=20), "speckle", STEEL)
    pieces.add(box((x, y, z - 0.15), (0.12, 0.12, 0.14)), "speckle", DARK)


scenes.register(SceneSource("workshop", SUMMARY, build, EFFECTS))
