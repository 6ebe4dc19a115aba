"""A room with a wide window under a sun that goes round in half a minute."""

from __future__ import annotations

from ...geometry import Pose
from .._scene import Background, Lamp, Scene
from ..motions import Spinning
from . import SceneSource, scenes
from ._models import StoredModel, textures

SUMMARY = "a room with a window under a sun that turns: a patch of sun crosses the floor and lights the room"
WALK_BOUNDS_M = ((-1.2, 0.8, -0.8), (1.2, 2.0, 1.2))
SKY = Background((0.10, 0.22, 0.45), (0.45, 0.52, 0.60), (0.16, 0.15, 0.12))
SUN = (4.2, 3.7, 3.0)
DAY_S = 30.0
# The sun stands 40 degrees high in +x at time 0, and turns about the vertical axis.
NOON = Pose((0, 0, 0), (-0.2418448, 0.6644630, 0.2418448, 0.6644630))


def build() -> Scene:
    """Return the room; the same to the last bit every time."""
    painted = textures()
    return Scene(
        "sunroom",
        SUMMARY,
        StoredModel("sunroom").meshes(painted),
        painted,
        SKY,
        walk_bounds_m=WALK_BOUNDS_M,
        lamps=[Lamp(Spinning(NOON, (0, 1, 0), 6.2832 / DAY_S), SUN, is_sun=True)],
    )


scenes.register(SceneSource("sunroom", SUMMARY, build))
