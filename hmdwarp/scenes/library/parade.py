"""A flag in the wind and a figure that marches on the spot and waves, on a deck with a view."""

from __future__ import annotations

import attrs
import numpy as np

from .._mesh import Deformation
from .._scene import Scene
from ..motions import Joint, Skinned, Waving
from . import SceneSource, scenes
from ._models import SKY, StoredModel, deck_textures

SUMMARY = "a walled deck with a waving flag and a marching figure that waves: soft motion by itself"
WALK_BOUNDS_M = ((-1.0, 0.8, -1.0), (1.2, 2.2, 1.6))
# Away from the viewer at an angle, so that the flag's swing is seen from the side.
DOWNWIND = np.array([np.cos(0.9), 0.0, -np.sin(0.9)])
FIGURE = np.array((0.55, 0.0, -2.3))  # on the ground below the hips
STEP_S = 2.0  # time of two steps
HIP_Y, KNEE_Y, CHEST_Y, NECK_Y, SHOULDER_Y, ELBOW_Y = 0.92, 0.50, 1.05, 1.46, 1.40, 1.12
SHOULDER_X, HIP_X = 0.24, 0.11


def build() -> Scene:
    """Return the parade; the same to the last bit every time."""
    model, textures = StoredModel("parade"), deck_textures("flag")
    deformations = {"flag": flag(model)} | {name: skin(model, name) for name in ("figure-fabric", "figure-speckle")}
    meshes = [attrs.evolve(mesh, deformation=deformations.get(mesh.name)) for mesh in model.meshes(textures)]
    return Scene("parade", SUMMARY, meshes, textures, SKY, walk_bounds_m=WALK_BOUNDS_M)


def flag(model: StoredModel) -> Deformation:
    """Return the motion of the flag: to and fro across the wind, lower rows a little behind."""
    rest, (away, lag) = model.doubles("flag-rest", 3), (model.doubles(f"flag-{of}", 1)[:, 0] for of in ("away", "lag"))
    swings = np.cross(DOWNWIND, (0, 1, 0)) + (0, 0.2, 0)
    return Waving(rest, away, swings, height_m=0.2, length_m=1.1, period_s=2.2, lag=lag)


def skin(model: StoredModel, mesh: str) -> Deformation:
    """Return the motion of one mesh of the figure."""
    which, weights = (model.doubles(f"{mesh}-{of}", 2) for of in ("joints", "weights"))
    return Skinned(model.doubles(f"{mesh}-rest", 3), joints(), which, weights)


def joints() -> tuple[Joint, ...]:
    """Return the figure's joints; it faces +z."""

    def joint(name: str, parent: int, x: float, y: float, axis: tuple[int, int, int], **swing: float) -> Joint:
        return Joint(name, parent, FIGURE + (x, y, 0), axis, **{"period_s": STEP_S} | swing)

    hips, chest, right_arm, left_arm, right_leg, left_leg = 0, 1, 3, 5, 7, 9
    across, ahead, up = (1, 0, 0), (0, 0, 1), (0, 1, 0)
    return (
        joint("hips", -1, 0, HIP_Y, up, swing_rad=0.10),
        joint("chest", hips, 0, CHEST_Y, up, swing_rad=0.16, phase=0.5),
        joint("head", chest, 0, NECK_Y, up, swing_rad=0.35, period_s=2 * STEP_S),
        joint("right arm", chest, -SHOULDER_X, SHOULDER_Y, ahead, middle_rad=-2.3, swing_rad=0.22),
        joint("right hand", right_arm, -SHOULDER_X, ELBOW_Y, ahead, middle_rad=-0.45, swing_rad=0.45, phase=0.1),
        joint("left arm", chest, SHOULDER_X, SHOULDER_Y, across, swing_rad=0.5),
        joint("left hand", left_arm, SHOULDER_X, ELBOW_Y, across, middle_rad=-0.5, swing_rad=0.2),
        joint("right leg", hips, -HIP_X, HIP_Y, across, middle_rad=-0.35, swing_rad=0.35),
        joint("right shin", right_leg, -HIP_X, KNEE_Y, across, middle_rad=0.4, swing_rad=-0.4),
        joint("left leg", hips, HIP_X, HIP_Y, across, middle_rad=-0.35, swing_rad=0.35, phase=0.5),
        joint("left shin", left_leg, HIP_X, KNEE_Y, across, middle_rad=0.4, swing_rad=-0.4, phase=0.5),
    )


scenes.register(SceneSource("parade", SUMMARY, build, ("soft_motion",)))
