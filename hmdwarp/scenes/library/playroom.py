"""A room in which people act: a ball to bounce, a lamp to switch, a door to open."""

from __future__ import annotations

from typing import Any

from ...geometry import Pose
from .._mesh import Body
from .._scene import Lamp, Scene
from ..input_events import InputLog
from ..motions import Still
from ..reactions import Bouncing, Hinged, Switched
from . import SceneSource, scenes
from ._models import StoredModel, textures

SUMMARY = "a room with a ball, a lamp and a cupboard's door that react to what people do (--input): still until then"
WALK_BOUNDS_M = ((-1.2, 0.8, -0.8), (1.2, 2.0, 1.2))
ROOM = ((-2.2, 0.0, -3.6), (2.2, 2.7, 2.0))
# The cupboard on the back wall: from left to right, from its bottom to its top, its front.
LEFT, RIGHT, LOW, HIGH, FRONT = -1.4, -0.5, 0.9, 1.9, -3.15
THICK = 0.03
SWITCH = (0.75, 1.25, -3.6)
BALL_RADIUS_M = 0.14
BALL_AT = (0.45, -1.9)  # x and z


def build() -> Scene:
    """Return the room; the same to the last bit every time."""
    painted = textures()
    return Scene(
        "playroom",
        SUMMARY,
        StoredModel("playroom").meshes(painted),
        painted,
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


scenes.register(SceneSource("playroom", SUMMARY, build, ("rigid_motion",), reacting))
