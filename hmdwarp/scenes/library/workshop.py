"""Three moving bodies on a deck full of still things: a fan, a cart and a thrown ball."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from ...geometry import Pose
from .._mesh import Body
from .._scene import Scene
from ..motions import Spinning, Thrown, Track
from . import SceneSource, scenes
from ._models import SKY, StoredModel, deck_textures

SUMMARY = "a walled deck with a turning fan, a cart on its round and a thrown ball: rigid motion by itself"
WALK_BOUNDS_M = ((-1.2, 0.8, -1.2), (1.2, 2.2, 1.6))
FAN = (-1.15, 1.45, -2.05)
FAN_RAD_S = 2.6
BASKETS = ((1.75, 0.55, -2.6), (-0.35, 0.55, -2.9))  # the ball flies from the first into the second
FLIGHT_S = 1.1
OVAL = (0.25, -4.0, 1.75, 0.62)  # of the cart: middle x and z, half width, half depth
LAP_S = 9.0


def build() -> Scene:
    """Return the workshop; the same to the last bit every time."""
    textures = deck_textures()
    meshes = StoredModel("workshop").meshes(textures)
    return Scene("workshop", SUMMARY, meshes, textures, SKY, bodies(), walk_bounds_m=WALK_BOUNDS_M)


def bodies() -> tuple[Body, ...]:
    """Return fan, cart and ball, in the order of their numbers."""
    start, end = (np.array(basket) - (0, 0.08, 0) for basket in BASKETS)
    across = (end - start) / FLIGHT_S
    up = np.array([0, 0.5 * 9.81 * FLIGHT_S, 0])
    return (
        Body("fan", Spinning(Pose(FAN), (0, 0, 1), FAN_RAD_S)),
        Body("cart", cart_track()),
        Body("ball", Thrown(Pose(start), across + up, FLIGHT_S, spin_rad_s=(1.0, 2.0, -3.0))),
    )


def cart_track(keys: int = 48) -> Track:
    """Return a track round an oval at an even pace, facing along it."""
    x, z, wide, deep = OVAL
    angle = np.linspace(0, 2 * np.pi, keys + 1)
    places = np.stack([x + wide * np.cos(angle), np.zeros(keys + 1), z + deep * np.sin(angle)], axis=1)
    along = np.stack([-wide * np.sin(angle), deep * np.cos(angle)], axis=1)
    heading = np.unwrap(np.arctan2(-along[:, 1], along[:, 0]))
    # Keys as far apart in time as in space keep the pace even.
    steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    times = np.concatenate([[0], np.cumsum(steps)]) / steps.sum() * LAP_S
    return Track(times, places, Rotation.from_euler("y", heading[:, None]))


scenes.register(SceneSource("workshop", SUMMARY, build, ("rigid_motion",)))
