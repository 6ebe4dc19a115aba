"""A room under a lamp that swings: shadows, and the light between the walls, never stand still."""

from __future__ import annotations

import attrs
import numpy as np

from .._mesh import Body
from .._scene import Lamp, Scene, SceneSource, scenes
from ..motions import Pendulum
from ..shapes import Ball
from ._models import box, in_atlas, textures, wall

SUMMARY = "a room with coloured walls under a lamp that swings: shadows and indirect light move"
WALK_BOUNDS_M = ((-1.2, 0.8, -0.8), (1.2, 2.0, 1.2))
SWING = Pendulum((0.0, 2.55, -0.9), 0.75, 0.7, 2.4, heading_rad=0.4)
LAMP = (1.5, 1.35, 1.1)
BULB_RADIUS_M = 0.06
WHITE, RED, BLUE, WOOD = (0.85, 0.85, 0.85), (0.80, 0.16, 0.10), (0.12, 0.22, 0.75), (0.62, 0.42, 0.25)


def build() -> Scene:
    """Return the room; the same to the last bit every time."""
    quads = [
        wall((0, 0, -0.8), (2.2, 0, 0), (0, 0, -2.8), WHITE, 1),
        wall((0, 2.7, -0.8), (2.2, 0, 0), (0, 0, 2.8), WHITE),
        wall((0, 1.35, -3.6), (2.2, 0, 0), (0, 1.35, 0), WHITE),
        wall((0, 1.35, 2.0), (-2.2, 0, 0), (0, 1.35, 0), WHITE),
        wall((-2.2, 1.35, -0.8), (0, 0, -2.8), (0, 1.35, 0), RED),
        wall((2.2, 1.35, -0.8), (0, 0, 2.8), (0, 1.35, 0), BLUE),
        *box((-1.5, 0, -2.9), (-0.8, 1.3, -2.2), WOOD),
        *box((0.5, 0, -2.4), (1.6, 0.75, -1.6), WHITE),
        *box((0.9, 0.75, -2.2), (1.2, 1.15, -1.9), WOOD),
    ]
    bulb = Ball((0, 0, 0), BULB_RADIUS_M, -1).mesh("bulb", 12)
    bulb = attrs.evolve(bulb, light=np.full_like(bulb.light, 1.0), body=1)
    meshes = [*in_atlas(quads, 0.35), bulb]
    return Scene(
        "lantern",
        SUMMARY,
        meshes,
        textures(),
        bodies=[Body("bulb", SWING)],
        walk_bounds_m=WALK_BOUNDS_M,
        lamps=[Lamp(SWING, LAMP)],
    )


scenes.register(SceneSource("lantern", SUMMARY, build, ("rigid_motion",)))
