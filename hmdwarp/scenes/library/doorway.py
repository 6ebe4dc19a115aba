"""Two rooms and a door that opens and shuts: the light of one falls into the other."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from ...geometry import Pose
from .._mesh import Body
from .._scene import Lamp, Scene
from ..motions import Still, Track
from . import SceneSource, scenes
from ._models import StoredModel, textures

SUMMARY = "a dim room beside a bright one: a door opens and shuts, and lets a wedge of light in"
WALK_BOUNDS_M = ((-1.2, 0.8, -0.7), (1.2, 2.0, 1.2))
HINGE = (-0.55, 0.0, -2.0)  # of the door, on the floor; its own axes begin there
# (s, rad): shut for half a second, open for one.
SWING = ((0.0, 0.0), (0.5, 0.0), (2.0, 1.75), (3.0, 1.75), (4.5, 0.0))


def build() -> Scene:
    """Return the rooms; the same to the last bit every time."""
    painted = textures()
    times, angles = np.array(SWING).T
    turns = Rotation.from_rotvec(np.outer(-angles, (0, 1, 0)))
    return Scene(
        "doorway",
        SUMMARY,
        StoredModel("doorway").meshes(painted),
        painted,
        bodies=[Body("door", Track(times, np.tile(HINGE, (len(times), 1)), turns))],
        walk_bounds_m=WALK_BOUNDS_M,
        lamps=[
            Lamp(Still(Pose((-1.1, 1.9, -3.4))), (4.6, 4.2, 3.6)),
            Lamp(Still(Pose((-0.6, 2.3, 1.2))), (0.22, 0.26, 0.34)),
        ],
    )


scenes.register(SceneSource("doorway", SUMMARY, build, ("rigid_motion",)))
