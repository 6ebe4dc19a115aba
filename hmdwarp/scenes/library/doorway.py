"""Two rooms and a door that opens and shuts: the light of one falls into the other."""

from __future__ import annotations

import attrs
import numpy as np
from scipy.spatial.transform import Rotation

from ...geometry import Pose
from .._mesh import Body
from .._scene import Lamp, Scene, SceneSource, scenes
from ..motions import Still, Track
from ..shapes import Quad
from ._models import box, in_atlas, textures, wall

SUMMARY = "a dim room beside a bright one: a door opens and shuts, and lets a wedge of light in"
WALK_BOUNDS_M = ((-1.2, 0.8, -0.7), (1.2, 2.0, 1.2))
WHITE, RED, BLUE, WOOD = (0.85, 0.85, 0.85), (0.80, 0.16, 0.10), (0.12, 0.22, 0.75), (0.62, 0.42, 0.25)
TEXEL_M = 0.42
# The doorway: from left to right, how high, and the wall's two sides. The door fills it, flush with
# the front.
LEFT, RIGHT, HIGH, FRONT, BACK = -0.55, 0.45, 2.05, -2.0, -2.12
THICK = 0.04
# (s, rad): shut for half a second, open for one.
SWING = ((0.0, 0.0), (0.5, 0.0), (2.0, 1.75), (3.0, 1.75), (4.5, 0.0))


def build() -> Scene:
    """Return the rooms; the same to the last bit every time."""
    west, east, south, north, roof = -2.2, 2.2, 2.0, -4.6, 2.7
    depth, middle = (FRONT - BACK) / 2, (FRONT + BACK) / 2
    here, there = ((south + FRONT) / 2, (south - FRONT) / 2), ((FRONT + north) / 2, (FRONT - north) / 2)
    parts = (  # of the wall around the doorway, on both sides: from where to where
        ((west, 0.0), (LEFT, roof)),
        ((RIGHT, 0.0), (east, roof)),
        ((LEFT, HIGH), (RIGHT, roof)),
    )
    still = [
        # Each room has a floor and a ceiling of its own, so that no texel lies in both.
        *(wall((0, 0, at), (east, 0, 0), (0, 0, -half), WHITE, 1) for at, half in (here, there)),
        *(wall((0, roof, at), (east, 0, 0), (0, 0, half), WHITE) for at, half in (here, there)),
        wall((0, roof / 2, north), (east, 0, 0), (0, roof / 2, 0), WHITE),
        wall((0, roof / 2, south), (west, 0, 0), (0, roof / 2, 0), WHITE),
        wall((west, roof / 2, (south + FRONT) / 2), (0, 0, (FRONT - south) / 2), (0, roof / 2, 0), BLUE),
        wall((west, roof / 2, (BACK + north) / 2), (0, 0, (north - BACK) / 2), (0, roof / 2, 0), WHITE),
        wall((east, roof / 2, (south + FRONT) / 2), (0, 0, (south - FRONT) / 2), (0, roof / 2, 0), RED),
        wall((east, roof / 2, (BACK + north) / 2), (0, 0, (BACK - north) / 2), (0, roof / 2, 0), WHITE),
        *(_part(low, high, FRONT, 1) for low, high in parts),
        *(_part(low, high, BACK, -1) for low, high in parts),
        wall((LEFT, HIGH / 2, middle), (0, 0, -depth), (0, HIGH / 2, 0), WHITE),
        wall((RIGHT, HIGH / 2, middle), (0, 0, depth), (0, HIGH / 2, 0), WHITE),
        wall(((LEFT + RIGHT) / 2, HIGH, middle), ((RIGHT - LEFT) / 2, 0, 0), (0, 0, depth), WHITE),
        *box((1.0, 0, -1.1), (1.5, 0.7, -0.5), WHITE),
        *box((0.3, 0, -4.3), (1.2, 1.1, -3.6), WOOD),
    ]
    # The door's own axes begin at its hinge, on the floor.
    hinge = np.array([LEFT, 0.0, FRONT])
    door = box((0, 0, -THICK), (RIGHT - LEFT, HIGH, 0), WOOD)
    meshes = in_atlas([*still, *door], TEXEL_M)
    meshes[len(still) :] = [attrs.evolve(mesh, body=1, name=f"door-{k}") for k, mesh in enumerate(meshes[len(still) :])]
    times, angles = np.array(SWING).T
    turns = Rotation.from_rotvec(np.outer(-angles, (0, 1, 0)))
    return Scene(
        "doorway",
        SUMMARY,
        meshes,
        textures(),
        bodies=[Body("door", Track(times, np.tile(hinge, (len(times), 1)), turns))],
        walk_bounds_m=WALK_BOUNDS_M,
        lamps=[
            Lamp(Still(Pose((-1.1, 1.9, -3.4))), (4.6, 4.2, 3.6)),
            Lamp(Still(Pose((-0.6, 2.3, 1.2))), (0.22, 0.26, 0.34)),
        ],
    )


def _part(low: tuple[float, float], high: tuple[float, float], z: float, sign: int) -> Quad:
    (left, bottom), (right, top) = low, high
    return wall(
        ((left + right) / 2, (bottom + top) / 2, z),
        (sign * (right - left) / 2, 0, 0),
        (0, (top - bottom) / 2, 0),
        WHITE,
    )


scenes.register(SceneSource("doorway", SUMMARY, build, ("rigid_motion",)))
