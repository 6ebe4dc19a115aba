"""A room with a wide window under a sun that goes round in half a minute."""

from __future__ import annotations

from ...geometry import Pose
from .._scene import Background, Lamp, Scene, SceneSource, scenes
from ..motions import Spinning
from ._models import box, in_atlas, textures, wall

SUMMARY = "a room with a window under a sun that turns: a patch of sun crosses the floor and lights the room"
WALK_BOUNDS_M = ((-1.2, 0.8, -0.8), (1.2, 2.0, 1.2))
SKY = Background((0.10, 0.22, 0.45), (0.45, 0.52, 0.60), (0.16, 0.15, 0.12))
SUN = (4.2, 3.7, 3.0)
DAY_S = 30.0
# The sun stands 40 degrees high in +x at time 0, and turns about the vertical axis.
NOON = Pose((0, 0, 0), (-0.2418448, 0.6644630, 0.2418448, 0.6644630))
WHITE, GREEN, WOOD = (0.85, 0.85, 0.85), (0.20, 0.55, 0.22), (0.62, 0.42, 0.25)


def build() -> Scene:
    """Return the room; the same to the last bit every time."""
    quads = [
        wall((0, 0, -0.8), (2.2, 0, 0), (0, 0, -2.8), WHITE, 1),
        wall((0, 2.7, -0.8), (2.2, 0, 0), (0, 0, 2.8), WHITE),
        wall((0, 1.35, -3.6), (2.2, 0, 0), (0, 1.35, 0), WHITE),
        wall((0, 1.35, 2.0), (-2.2, 0, 0), (0, 1.35, 0), WHITE),
        wall((-2.2, 1.35, -0.8), (0, 0, -2.8), (0, 1.35, 0), GREEN),
        # The right-hand wall, around a window from z = -2.6 to 0.4 and from 0.8 to 2.2 m.
        wall((2.2, 0.4, -0.8), (0, 0, 2.8), (0, 0.4, 0), WHITE),
        wall((2.2, 2.45, -0.8), (0, 0, 2.8), (0, 0.25, 0), WHITE),
        wall((2.2, 1.5, -3.1), (0, 0, 0.5), (0, 0.7, 0), WHITE),
        wall((2.2, 1.5, 1.2), (0, 0, 0.8), (0, 0.7, 0), WHITE),
        *box((-1.5, 0, -2.9), (-0.8, 1.3, -2.2), WOOD),
        *box((0.3, 0, -2.4), (1.3, 0.75, -1.6), WHITE),
    ]
    return Scene(
        "sunroom",
        SUMMARY,
        in_atlas(quads, 0.35),
        textures(),
        SKY,
        walk_bounds_m=WALK_BOUNDS_M,
        lamps=[Lamp(Spinning(NOON, (0, 1, 0), 6.2832 / DAY_S), SUN, is_sun=True)],
    )


scenes.register(SceneSource("sunroom", SUMMARY, build))
