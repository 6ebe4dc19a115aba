"""A person who marches on the spot and waves: a skin over eleven joints. Faces +z, stands on y = 0."""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

from .._model import Mesh
from ..deformations import Joint, Skinned
from ._pieces import Piece, Pieces
from ._surfaces import Surface, box, cushion, tube
from ._yard import DARK, body_lights

STEP_S = 2.0  # of two steps
SKIN, COAT, TROUSERS, HAT = (0.86, 0.62, 0.48), (0.62, 0.12, 0.11), (0.20, 0.24, 0.36), (0.16, 0.14, 0.15)
BLEND_M = 0.05  # over which a limb passes from one joint to the next
HIP_Y, KNEE_Y, CHEST_Y, NECK_Y, SHOULDER_Y, ELBOW_Y = 0.92, 0.50, 1.05, 1.46, 1.40, 1.12
SHOULDER_X, HIP_X = 0.24, 0.11
HIPS, CHEST, HEAD, RIGHT_ARM, RIGHT_HAND, LEFT_ARM, LEFT_HAND, RIGHT_LEG, RIGHT_SHIN, LEFT_LEG, LEFT_SHIN = range(11)


def joints(place: NDArray) -> tuple[Joint, ...]:
    """Where `place` is the point on the ground below the hips."""

    def joint(name: str, parent: int, pivot: tuple, axis: tuple, **swing: float) -> Joint:
        return Joint(name, parent, place + pivot, axis, **{"period_s": STEP_S} | swing)

    right, left = -1, 1  # of the figure, which faces the viewer
    across, ahead, up = (1, 0, 0), (0, 0, 1), (0, 1, 0)
    return (
        joint("hips", -1, (0, HIP_Y, 0), up, swing_rad=0.10),
        joint("chest", HIPS, (0, CHEST_Y, 0), up, swing_rad=0.16, phase=0.5),
        joint("head", CHEST, (0, NECK_Y, 0), up, swing_rad=0.35, period_s=2 * STEP_S),
        joint("right arm", CHEST, (right * SHOULDER_X, SHOULDER_Y, 0), ahead, middle_rad=-2.3, swing_rad=0.22),
        joint(
            "right hand",
            RIGHT_ARM,
            (right * SHOULDER_X, ELBOW_Y, 0),
            ahead,
            middle_rad=-0.45,
            swing_rad=0.45,
            phase=0.1,
        ),
        joint("left arm", CHEST, (left * SHOULDER_X, SHOULDER_Y, 0), across, swing_rad=0.5, phase=0.0),
        joint("left hand", LEFT_ARM, (left * SHOULDER_X, ELBOW_Y, 0), across, middle_rad=-0.5, swing_rad=0.2),
        joint("right leg", HIPS, (right * HIP_X, HIP_Y, 0), across, middle_rad=-0.35, swing_rad=0.35, phase=0.0),
        joint("right shin", RIGHT_LEG, (right * HIP_X, KNEE_Y, 0), across, middle_rad=0.4, swing_rad=-0.4, phase=0.0),
        joint("left leg", HIPS, (left * HIP_X, HIP_Y, 0), across, middle_rad=-0.35, swing_rad=0.35, phase=0.5),
        joint("left shin", LEFT_LEG, (left * HIP_X, KNEE_Y, 0), across, middle_rad=0.4, swing_rad=-0.4, phase=0.5),
    )


@attrs.frozen(eq=False)
class _Limb:
    """A piece of the figure and the chain of joints along it, each from its height downwards (or upwards for a trunk)."""

    piece: Piece
    chain: tuple[int, ...]
    pivots_y: tuple[float, ...] = ()

    def weights(self) -> NDArray[np.float64]:
        """(n, 11): joints' shares by height, with soft passages at the pivots."""
        out = np.zeros((len(self.piece.surface.positions), 11))
        y, left = self.piece.surface.positions[:, 1], 1.0
        for joint, above in zip(self.chain, (*self.pivots_y, None), strict=True):
            below = 0.0 if above is None else _smooth((above - y) / BLEND_M)
            out[:, joint] += left * (1 - below)
            left = left * below
        return out


def _smooth(t: NDArray) -> NDArray:
    t = np.clip(0.5 + 0.5 * t, 0, 1)
    return t * t * (3 - 2 * t)


def _limbs() -> list[_Limb]:
    pieces = Pieces()
    chains: list[tuple[tuple[int, ...], tuple[float, ...]]] = []

    def add(surface: Surface, texture: str, tint: tuple, chain: tuple[int, ...], *pivots_y: float) -> None:
        pieces.add(surface, texture, tint)
        chains.append((chain, pivots_y))

    add(
        cushion((0, 1.18, 0), (0.46, 0.62, 0.26), roundness=0.7, rings=20, sides=28),
        "fabric",
        COAT,
        (CHEST, HIPS),
        CHEST_Y,
    )
    add(cushion((0, 0.94, 0), (0.36, 0.26, 0.24), roundness=0.7), "fabric", TROUSERS, (HIPS,))
    add(tube([(0, 1.40, 0), (0, 1.47, 0), (0, 1.54, 0.01)], 0.055, sides=14), "speckle", SKIN, (HEAD,))
    add(cushion((0, 1.64, 0.01), (0.19, 0.26, 0.22), roundness=0.9, rings=16, sides=24), "speckle", SKIN, (HEAD,))
    add(cushion((0, 1.77, 0.0), (0.22, 0.16, 0.24), roundness=0.5), "fabric", HAT, (HEAD,))
    add(box((0, 1.72, 0.10), (0.2, 0.02, 0.12)), "fabric", HAT, (HEAD,))
    for x in (-0.04, 0.04):
        add(cushion((x, 1.66, 0.115), (0.03, 0.03, 0.02), roundness=1, rings=6, sides=8), "speckle", DARK, (HEAD,))
    for k in range(4):
        add(
            cushion((0, 1.02 + 0.1 * k, 0.125), (0.03, 0.03, 0.02), roundness=1, rings=6, sides=8),
            "speckle",
            (0.9, 0.7, 0.25),
            (CHEST,),
        )
    for side, arm, hand, leg, shin in (
        (-1, RIGHT_ARM, RIGHT_HAND, RIGHT_LEG, RIGHT_SHIN),
        (1, LEFT_ARM, LEFT_HAND, LEFT_LEG, LEFT_SHIN),
    ):
        x = side * SHOULDER_X
        down = np.linspace(1.44, 0.88, 22)
        sleeve = np.stack([np.full(22, x), down, np.zeros(22)], axis=1)
        add(tube(sleeve, np.linspace(0.075, 0.05, 22), sides=16), "fabric", COAT, (arm, hand), ELBOW_Y)
        add(cushion((x, 1.42, 0), (0.16, 0.14, 0.16), roundness=1), "fabric", COAT, (arm,))
        add(cushion((x, 0.82, 0), (0.09, 0.19, 0.06), roundness=0.8), "speckle", SKIN, (hand,))
        x = side * HIP_X
        down = np.linspace(0.95, 0.08, 30)
        trouser = np.stack([np.full(30, x), down, np.zeros(30)], axis=1)
        add(tube(trouser, np.linspace(0.1, 0.07, 30), sides=16), "fabric", TROUSERS, (leg, shin), KNEE_Y)
        add(cushion((x, 0.055, 0.05), (0.11, 0.11, 0.28), roundness=0.6), "speckle", DARK, (shin,))
    return [_Limb(piece, chain, pivots) for piece, (chain, pivots) in zip(pieces, chains, strict=True)]


def figure_meshes(place: tuple[float, float, float], texture_index) -> list[Mesh]:
    """One mesh for each texture, standing at `place`."""
    at, limbs = np.array(place, np.float64), _limbs()
    bones = joints(at)
    meshes = []
    for texture in sorted({limb.piece.texture for limb in limbs}):
        mine = [limb for limb in limbs if limb.piece.texture == texture]
        meshes.append(_skinned(f"figure-{texture}", mine, at, bones, texture_index(texture)))
    return meshes


def _skinned(name: str, limbs: list[_Limb], place: NDArray, bones: tuple[Joint, ...], texture: int) -> Mesh:
    surfaces = [limb.piece.surface for limb in limbs]
    lights = [
        light * np.array(limb.piece.tint)
        for light, limb in zip(body_lights([limb.piece for limb in limbs]), limbs, strict=True)
    ]
    starts = np.cumsum([0, *(len(surface.positions) for surface in surfaces)])
    weights = np.concatenate([limb.weights() for limb in limbs])
    which = np.argsort(-weights, axis=1, kind="stable")[:, :2]
    rest = np.concatenate([surface.positions for surface in surfaces]) + place
    skin = Skinned(rest, bones, which, np.take_along_axis(weights, which, axis=1))
    return Mesh(
        name,
        rest,
        np.concatenate([surface.normals for surface in surfaces]),
        np.concatenate([surface.uv for surface in surfaces]),
        np.concatenate(lights),
        np.concatenate([s.triangles + np.uint32(start) for s, start in zip(surfaces, starts, strict=False)]),
        texture,
        deformation=skin,
    )
