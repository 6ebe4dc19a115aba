"""A room under a lamp that swings: shadows, and the light between the walls, never stand still."""

from __future__ import annotations

from .._mesh import Body
from .._scene import Lamp, Scene
from ..motions import Pendulum
from . import SceneSource, scenes
from ._models import StoredModel, textures

SUMMARY = "a room with coloured walls under a lamp that swings: shadows and indirect light move"
WALK_BOUNDS_M = ((-1.2, 0.8, -0.8), (1.2, 2.0, 1.2))
SWING = Pendulum((0.0, 2.55, -0.9), 0.75, 0.7, 2.4, heading_rad=0.4)
LAMP = (1.5, 1.35, 1.1)


def build() -> Scene:
    """Return the room; the same to the last bit every time."""
    painted = textures()
    return Scene(
        "lantern",
        SUMMARY,
        StoredModel("lantern").meshes(painted),
        painted,
        bodies=[Body("bulb", SWING)],
        walk_bounds_m=WALK_BOUNDS_M,
        lamps=[Lamp(SWING, LAMP)],
    )


scenes.register(SceneSource("lantern", SUMMARY, build, ("rigid_motion",)))
