"""A room in which people act: a ball to bounce, a lamp to switch, a door to open."""

from __future__ import annotations

from typing import Any

import attrs

from ...geometry import Pose
from .._mesh import Body
from .._scene import Lamp, Scene, SceneSource, scenes
from ..input_events import InputLog
from ..motions import Still
from ..reactions import Bouncing, Hinged, Switched
from ..shapes import Ball
from ._models import box, in_atlas, textures, wall

SUMMARY = "a room with a ball, a lamp and a cupboard's door that react to what people do (--input): still until then"
WALK_BOUNDS_M = ((-1.2, 0.8, -0.8), (1.2, 2.0, 1.2))
ROOM = ((-2.2, 0.0, -3.6), (2.2, 2.7, 2.0))
WHITE, RED, BLUE, WOOD = (0.85, 0.85, 0.85), (0.80, 0.16, 0.10), (0.12, 0.22, 0.75), (0.62, 0.42, 0.25)
TEXEL_M = 0.38
# The cupboard on the back wall: from left to right, from its bottom to its top, its front.
LEFT, RIGHT, LOW, HIGH, FRONT = -1.4, -0.5, 0.9, 1.9, -3.15
THICK = 0.03
SWITCH = (0.75, 1.25, -3.6)
BALL_RADIUS_M = 0.14
BALL_AT = (0.45, -1.9)  # x and z


def build() -> Scene:
    """Return the room; the same to the last bit every time."""
    still, door = _walls(), box((0, 0, -THICK), (RIGHT - LEFT, HIGH - LOW, 0), WOOD)
    lit = in_atlas([*still, *door], TEXEL_M)
    leaf = [attrs.evolve(mesh, body=2, name=f"door-{k}") for k, mesh in enumerate(lit[len(still) :])]
    ball = Ball((0, 0, 0), BALL_RADIUS_M, 1, (0.95, 0.55, 0.15)).mesh("ball", 16)
    return Scene(
        "playroom",
        SUMMARY,
        [*lit[: len(still)], *leaf, attrs.evolve(ball, body=1)],
        textures(),
        walk_bounds_m=WALK_BOUNDS_M,
        **reacting(InputLog()),
    )


def reacting(inputs: InputLog) -> dict[str, Any]:
    """Return ball and door, in the order of their numbers, and the lamps."""
    ball = Bouncing("ball", inputs, BALL_AT, BALL_RADIUS_M, ROOM)
    door = Hinged("door", inputs, (LEFT, LOW, FRONT + THICK), (0.9 * (RIGHT - LEFT), (HIGH - LOW) / 2, 0.0))
    lamp = Switched("lamp", inputs, SWITCH)
    return {
        "bodies": (Body("ball", ball), Body("door", door)),
        "lamps": (
            Lamp(Still(Pose((0.7, 1.9, -1.4))), (1.3, 1.15, 0.95), brightness=lamp),
            Lamp(Still(Pose((-0.9, 2.0, 1.0))), (0.45, 0.5, 0.64)),
        ),
    }


def _walls() -> list[Any]:
    (west, ground, north), (east, roof, south) = ROOM
    middle, deep = (north + south) / 2, (south - north) / 2
    board, inner = (LEFT + RIGHT) / 2, (RIGHT - LEFT) / 2
    return [
        wall((0, ground, middle), (east, 0, 0), (0, 0, -deep), WHITE, 1),
        wall((0, roof, middle), (east, 0, 0), (0, 0, deep), WHITE),
        wall((0, roof / 2, north), (east, 0, 0), (0, roof / 2, 0), WHITE),
        wall((0, roof / 2, south), (west, 0, 0), (0, roof / 2, 0), WHITE),
        wall((west, roof / 2, middle), (0, 0, -deep), (0, roof / 2, 0), RED),
        wall((east, roof / 2, middle), (0, 0, deep), (0, roof / 2, 0), BLUE),
        # The cupboard's sides, shelves and what stands in it; its back is the wall.
        *box((LEFT, LOW, north), (LEFT + THICK, HIGH, FRONT), WOOD),
        *box((RIGHT - THICK, LOW, north), (RIGHT, HIGH, FRONT), WOOD),
        *box((LEFT, LOW - THICK, north), (RIGHT, LOW, FRONT), WOOD),
        *box((LEFT, HIGH, north), (RIGHT, HIGH + THICK, FRONT), WOOD),
        wall((board, HIGH, (north + FRONT) / 2), (inner, 0, 0), (0, 0, (FRONT - north) / 2), WOOD),
        *box((-1.15, LOW, -3.5), (-0.85, 1.45, -3.3), BLUE),
        # The switch's plate, around the place that a hand aims at.
        *box((SWITCH[0] - 0.06, SWITCH[1] - 0.06, north), (SWITCH[0] + 0.06, SWITCH[1] + 0.06, north + 0.02), RED),
        *box((1.8, 1.1, -3.1), (east, 1.35, -1.9), WHITE),
    ]


scenes.register(SceneSource("playroom", SUMMARY, build, ("rigid_motion",), reacting))
